// Light that spreads in snow, as a blur of the finished picture: cheap, and close enough for films.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace neve::render {

// A picture of `height` rows of `width` pixels: light has three numbers for each, the others one.
struct SpreadInput {
  const float *light, *snow, *depth, *radius;
  std::int64_t height, width;
};

// One colour of the light looks at `count` places around a pixel: right and down of it, in units of `radius`.
struct SpreadTaps {
  const float *right, *down;
  int count;
};

// out = l (1 - a) + a sum_k n_k l_k / sum_k n_k, a = share snow, and n_k = snow_k exp(-((z_k - z) / thick)^2) for the
// places k around the pixel, with 0.05 for itself; z the depth. taps: of red, green and blue.
inline void spread_light(const SpreadInput& in, const SpreadTaps* taps, float share, float thick,
                         float* out) {
  const std::int64_t w = in.width, h = in.height;
  const float reach_most = 0.05f * float(w), inv = 1.0f / thick;
#pragma omp parallel for schedule(dynamic, 8)
  for (std::int64_t row = 0; row < h; ++row)
    for (std::int64_t column = 0; column < w; ++column) {
      const std::int64_t at = row * w + column;
      const float snow = in.snow[at], depth = in.depth[at];
      const float reach = std::min(in.radius[at], reach_most), part = share * snow;
      for (int c = 0; c < 3; ++c) {
        const float own = in.light[3 * at + c];
        float total = 0.05f * own, weights = 0.05f;
        for (int k = 0; part > 0 && k < taps[c].count; ++k) {
          const float r = std::clamp(float(row) + taps[c].down[k] * reach, 0.0f, float(h - 1));
          const float q = std::clamp(float(column) + taps[c].right[k] * reach, 0.0f, float(w - 1));
          const std::int64_t there = std::int64_t(r) * w + std::int64_t(q);
          const float apart = (in.depth[there] - depth) * inv;
          const float near = std::exp(-apart * apart) * in.snow[there];
          total += near * in.light[3 * there + c];
          weights += near;
        }
        out[3 * at + c] = own * (1.0f - part) + part * total / weights;
      }
    }
}

}  // namespace neve::render
