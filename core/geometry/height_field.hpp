// Ground given by heights, with its samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "geometry/height_view.hpp"

namespace neve {

class HeightField {
 public:
  // `heights`: nx rows along x of ny heights along y [m]; the first and the last lie on the edges of the rectangle.
  // Errors: std::invalid_argument for fewer than two samples a side, no size, or a height that is not finite.
  HeightField(const float* heights, std::int32_t nx, std::int32_t ny, double size_x, double size_y) {
    view_.nx = nx, view_.ny = ny, view_.size_x = size_x, view_.size_y = size_y;
    if (nx < 2 || ny < 2) throw std::invalid_argument("heights: at least two samples a side");
    if (!(size_x > 0 && size_y > 0 && size_x < 1e30 && size_y < 1e30))
      throw std::invalid_argument("size: two lengths above zero");
    const auto count = std::size_t(nx) * std::size_t(ny);
    for (std::size_t n = 0; n < count; ++n) {
      if (!(std::fabs(heights[n]) < 1e30f)) throw std::invalid_argument("heights: one is not finite");
      low_ = std::min(low_, heights[n]), high_ = std::max(high_, heights[n]);
    }
    fill(heights);
    find_tops(heights);
    view_.quads = quads_.data(), view_.tops = tops_.data();
  }

  HeightField(const HeightField&) = delete;  // the view points into the samples
  HeightField& operator=(const HeightField&) = delete;

  const HeightView& view() const { return view_; }
  double low() const { return low_; }  // least and largest height [m]
  double high() const { return high_; }
  std::size_t bytes() const { return sizeof(*this) + (quads_.size() + tops_.size()) * sizeof(float); }

 private:
  void fill(const float* heights) {
    const auto h = [&](std::int32_t i, std::int32_t j) {
      return double(heights[view_.quad(std::clamp(i, 0, view_.nx - 1), std::clamp(j, 0, view_.ny - 1)) / 4]);
    };
    const double dx = view_.size_x / (view_.nx - 1), dy = view_.size_y / (view_.ny - 1);
    quads_.resize(view_.quad(view_.nx, 0));
    for (std::int32_t i = 0; i < view_.nx; ++i) {
      const double wide_x = dx * (std::min(i + 1, view_.nx - 1) - std::max(i - 1, 0));
      for (std::int32_t j = 0; j < view_.ny; ++j) {
        const double wide_y = dy * (std::min(j + 1, view_.ny - 1) - std::max(j - 1, 0));
        float* q = quads_.data() + view_.quad(i, j);
        q[0] = float(h(i, j));
        q[1] = float((h(i + 1, j) - h(i - 1, j)) / wide_x);
        q[2] = float((h(i, j + 1) - h(i, j - 1)) / wide_y);
        q[3] = 0;
      }
    }
  }

  // The largest height of each tile of 8^2 cells.
  void find_tops(const float* heights) {
    view_.tiles_x = (view_.nx - 2) / HeightView::tile_cells + 1,
    view_.tiles_y = (view_.ny - 2) / HeightView::tile_cells + 1;
    tops_.assign(std::size_t(view_.tiles_x) * std::size_t(view_.tiles_y), low_);
    for (std::int32_t i = 0; i < view_.tiles_x; ++i) {
      for (std::int32_t j = 0; j < view_.tiles_y; ++j) {
        float& top = tops_[std::size_t(i * view_.tiles_y + j)];
        const std::int32_t i_end = std::min(HeightView::tile_cells * (i + 1), view_.nx - 1),
                           j_end = std::min(HeightView::tile_cells * (j + 1), view_.ny - 1);
        for (std::int32_t a = HeightView::tile_cells * i; a <= i_end; ++a) {
          for (std::int32_t b = HeightView::tile_cells * j; b <= j_end; ++b)
            top = std::max(top, heights[view_.quad(a, b) / 4]);
        }
      }
    }
  }

  HeightView view_;
  float low_ = std::numeric_limits<float>::infinity(), high_ = -std::numeric_limits<float>::infinity();
  std::vector<float> quads_, tops_;  // as in HeightView
};

}  // namespace neve
