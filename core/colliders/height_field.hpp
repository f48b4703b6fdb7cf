// Ground given by heights over a rectangle, in its own frame: local z is up, the rectangle's middle is x = y = 0.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "colliders/surface.hpp"

namespace neve {

// Heights are bilinear between the samples; beyond an edge the edge's height goes on for ever. Below the surface all is
// ground, however deep.
//
// phi = (z - h) n_z, n along (-dh/dx, -dh/dy, 1): the distance to the tangent plane, exact for planes. Where the
// ground's steepest slope is s, the distance is between |z - h| / sqrt(1 + s^2) and |z - h|, and so is |phi|. Slopes
// are central differences at the samples, bilinear between: the normal turns smoothly over two spacings.
class HeightField {
 public:
  // `heights`: nx rows along x of ny heights along y [m]; the first and the last lie on the edges of the rectangle.
  // Errors: std::invalid_argument for fewer than two samples a side, no size, or a height that is not finite.
  HeightField(const float* heights, std::int32_t nx, std::int32_t ny, double size_x, double size_y)
      : nx_(nx), ny_(ny), size_x_(size_x), size_y_(size_y) {
    if (nx < 2 || ny < 2) throw std::invalid_argument("heights: at least two samples a side");
    if (!(size_x > 0 && size_y > 0 && size_x < 1e30 && size_y < 1e30))
      throw std::invalid_argument("size: two lengths above zero");
    const auto count = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
    for (std::size_t n = 0; n < count; ++n) {
      if (!(std::fabs(heights[n]) < 1e30f)) throw std::invalid_argument("heights: one is not finite");
      low_ = std::min(low_, heights[n]), high_ = std::max(high_, heights[n]);
    }
    fill(heights);
    find_tops(heights);
  }

  std::int32_t nx() const { return nx_; }
  std::int32_t ny() const { return ny_; }
  double size_x() const { return size_x_; }
  double size_y() const { return size_y_; }
  double low() const { return low_; }  // least and largest height [m]
  double high() const { return high_; }
  float height(std::int32_t i, std::int32_t j) const { return quads_[quad(i, j)]; }
  std::size_t bytes() const { return sizeof(*this) + (quads_.size() + tops_.size()) * sizeof(float); }

  // phi and normal at points in the ground's frame.
  template <class R>
  Surface<R> at(const Vec3<R>& x) const {
    using T = scalar_t<R>;
    const R a = (x.x + T(0.5 * size_x_)) * T((nx_ - 1) / size_x_);
    const R b = (x.y + T(0.5 * size_y_)) * T((ny_ - 1) / size_y_);
    const R u = clamp(a, R{}, splat<R>(T(nx_ - 1))), v = clamp(b, R{}, splat<R>(T(ny_ - 1)));
    alignas(64) T quads[4 * width<R>];
    for (int l = 0; l < width<R>; ++l) blend(detail::lane(u, l), detail::lane(v, l), quads + 4 * l);
    R h, slope_x, slope_y, unused;
    detail::packs_of_quads(quads, h, slope_x, slope_y, unused);
    slope_x = select(a == u, slope_x, R{});
    slope_y = select(b == v, slope_y, R{});
    const R n_z = rsqrt(R(slope_x * slope_x + slope_y * slope_y + T(1)));
    return {(x.z - h) * n_z, {-slope_x * n_z, -slope_y * n_z, n_z}};
  }

  // Whether the ground may be within `reach` [m] of x; false only if it is not.
  bool is_near(const Vec3<double>& x, double reach) const {
    const auto tile = [&](double at, double size, std::int32_t n, std::int32_t tiles) {
      const double cell = (at / size + 0.5) * (n - 1);
      return static_cast<std::int32_t>(std::clamp(std::floor(cell / tile_cells), 0.0, double(tiles - 1)));
    };
    const std::int32_t i1 = tile(x.x + reach, size_x_, nx_, tiles_x_),
                       j0 = tile(x.y - reach, size_y_, ny_, tiles_y_),
                       j1 = tile(x.y + reach, size_y_, ny_, tiles_y_);
    for (std::int32_t i = tile(x.x - reach, size_x_, nx_, tiles_x_); i <= i1; ++i) {
      for (std::int32_t j = j0; j <= j1; ++j) {
        if (x.z - reach <= double(tops_[static_cast<std::size_t>(i * tiles_y_ + j)])) return true;
      }
    }
    return false;
  }

 private:
  static constexpr int tile_cells = 8;

  std::size_t quad(std::int32_t i, std::int32_t j) const {
    return 4 * (static_cast<std::size_t>(i) * static_cast<std::size_t>(ny_) + static_cast<std::size_t>(j));
  }

  void fill(const float* heights) {
    const auto h = [&](std::int32_t i, std::int32_t j) {
      return double(heights[quad(std::clamp(i, 0, nx_ - 1), std::clamp(j, 0, ny_ - 1)) / 4]);
    };
    const double dx = size_x_ / (nx_ - 1), dy = size_y_ / (ny_ - 1);
    quads_.resize(quad(nx_, 0));
    for (std::int32_t i = 0; i < nx_; ++i) {
      const double wide_x = dx * (std::min(i + 1, nx_ - 1) - std::max(i - 1, 0));
      for (std::int32_t j = 0; j < ny_; ++j) {
        const double wide_y = dy * (std::min(j + 1, ny_ - 1) - std::max(j - 1, 0));
        float* q = quads_.data() + quad(i, j);
        q[0] = static_cast<float>(h(i, j));
        q[1] = static_cast<float>((h(i + 1, j) - h(i - 1, j)) / wide_x);
        q[2] = static_cast<float>((h(i, j + 1) - h(i, j - 1)) / wide_y);
        q[3] = 0;
      }
    }
  }

  // The largest height of each tile of 8^2 cells.
  void find_tops(const float* heights) {
    tiles_x_ = (nx_ - 2) / tile_cells + 1, tiles_y_ = (ny_ - 2) / tile_cells + 1;
    tops_.assign(static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_), low_);
    for (std::int32_t i = 0; i < tiles_x_; ++i) {
      for (std::int32_t j = 0; j < tiles_y_; ++j) {
        float& top = tops_[static_cast<std::size_t>(i * tiles_y_ + j)];
        const std::int32_t i_end = std::min(tile_cells * (i + 1), nx_ - 1),
                           j_end = std::min(tile_cells * (j + 1), ny_ - 1);
        for (std::int32_t a = tile_cells * i; a <= i_end; ++a) {
          for (std::int32_t b = tile_cells * j; b <= j_end; ++b) top = std::max(top, heights[quad(a, b) / 4]);
        }
      }
    }
  }

  // The quad at one point, in cells from the first corner.
  template <class T>
  void blend(T u, T v, T* out) const {
    const std::int32_t i = std::min(static_cast<std::int32_t>(u), nx_ - 2),
                       j = std::min(static_cast<std::int32_t>(v), ny_ - 2);
    const float* p = quads_.data() + quad(i, j);
    const auto a = detail::load_two_quads<T>(p), b = detail::load_two_quads<T>(p + quad(1, 0));
    detail::store_blend<T>(a + (b - a) * (u - T(i)), v - T(j), out);
  }

  std::int32_t nx_, ny_, tiles_x_ = 0, tiles_y_ = 0;
  double size_x_, size_y_;
  float low_ = std::numeric_limits<float>::infinity(), high_ = -std::numeric_limits<float>::infinity();
  std::vector<float> quads_;  // h [m], dh/dx, dh/dy, 0
  std::vector<float> tops_;   // [m]
};

}  // namespace neve
