// Flakes in the air: lines with round ends over a finished picture, as faint as they are short of a pixel's time.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "render/view/vec.hpp"

namespace neve::render {

// The way of a flake in the picture while the shutter is open.
struct Streak {
  float column[2], row[2];  // where it begins and ends [px]
  float radius;             // [px]
  float cover;              // share of what is behind it that it hides [1]
  float away;               // from the eye [m]
  float light[3];
};

// What flakes add to each pixel, and how much of what is behind them they let pass.
class Veil {
 public:
  struct Pixel {
    Vec3f light{0, 0, 0};
    float passes = 1;
  };

  // Draw streaks, the farthest first. nearest(r, c): how far what is seen in a pixel is from the eye [m].
  // Each thread draws rows of its own: the same bits for any number of them.
  template <class Nearest>
  void draw(int width, int height, std::span<const Streak> streaks, const Nearest& nearest) {
    width_ = width, height_ = height;
    pixels_.resize(std::size_t(width) * std::size_t(height));
#pragma omp parallel for schedule(dynamic)
    for (int first = 0; first < height; first += band) {
      const int last = std::min(first + band, height);
      std::fill(pixels_.data() + at(first, 0), pixels_.data() + at(last - 1, 0) + width, Pixel{});
      for (const Streak& streak : streaks) draw_rows(streak, first, last, nearest);
    }
  }
  const Pixel& pixel(int r, int c) const { return pixels_[at(r, c)]; }
  Vec3f over(int r, int c, Vec3f behind) const {
    const Pixel& p = pixel(r, c);
    return behind * p.passes + p.light;
  }
  // Whether a flake shows in rows [top, bottom) and columns [left, right).
  bool shows(int top, int bottom, int left, int right) const {
    for (int r = top; r < std::min(bottom, height_); ++r)
      for (int c = left; c < std::min(right, width_); ++c)
        if (pixel(r, c).passes < 1) return true;
    return false;
  }

 private:
  static constexpr int band = 16;  // rows drawn by one thread at a time

  std::size_t at(int r, int c) const { return std::size_t(r) * std::size_t(width_) + std::size_t(c); }

  template <class Nearest>
  void draw_rows(const Streak& s, int first, int last, const Nearest& nearest) {
    const float reach = s.radius + 1.0f;
    const int top = whole(std::min(s.row[0], s.row[1]) - reach, first, last),
              bottom = whole(std::max(s.row[0], s.row[1]) + reach + 1.0f, first, last),
              left = whole(std::min(s.column[0], s.column[1]) - reach, 0, width_),
              right = whole(std::max(s.column[0], s.column[1]) + reach + 1.0f, 0, width_);
    const float ax = s.column[1] - s.column[0], ay = s.row[1] - s.row[0];
    const float inv = 1.0f / std::max(ax * ax + ay * ay, 1e-12f);
    const Vec3f light{s.light[0], s.light[1], s.light[2]};
    for (int r = top; r < bottom; ++r)
      for (int c = left; c < right; ++c) {
        const float dx = float(c) + 0.5f - s.column[0], dy = float(r) + 0.5f - s.row[0];
        const float t = saturate((dx * ax + dy * ay) * inv);
        const float x = dx - t * ax, y = dy - t * ay;
        const float share = s.cover * saturate(s.radius - std::sqrt(x * x + y * y) + 0.5f);
        if (!(share > 0) || nearest(r, c) < s.away) continue;
        Pixel& p = pixels_[at(r, c)];
        p.light = p.light * (1 - share) + light * share;
        p.passes *= 1 - share;
      }
  }

  int width_ = 0, height_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace neve::render
