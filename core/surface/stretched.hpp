// A field of points whose kernels are stretched along axes of their own: flat ones where snow is flat.
#pragma once

#include <algorithm>
#include <vector>

#include "surface/carry.hpp"
#include "surface/field.hpp"

namespace neve::surface {

constexpr float most_kernel_cells = 64.0f;

// The quadratic B-spline at u cells from its middle.
inline float spline(float u) {
  u = std::abs(u);
  if (u < 0.5f) return 0.75f - u * u;
  return u < 1.5f ? 0.5f * (1.5f - u) * (1.5f - u) : 0.0f;
}

// How far the kernel of the stretch S reaches along an axis, in widths.
inline float kernel_reach(const Mat3f& S, int axis) {
  return 1.5f * (std::abs(S(axis, 0)) + std::abs(S(axis, 1)) + std::abs(S(axis, 2)));
}

// Spread amounts over cells with kernels prod_k N((S_p^-1 (x - x_p))_k / width), N the quadratic B-spline, and blur that
// `blurs` times. Each kernel is divided by its sum over the cells, so that the grid holds what the points hold.
// S(p): symmetric stretch of the kernel of point p; with S = 1 and width = cell_size the field is that of `of_points`.
template <class F>
Field of_stretched(std::span<const Vec3f> x, std::span<const float> amounts, F&& S, float width,
                   float cell_size, int blurs) {
  Field field{Blocks(cell_size)};
  Blocks& blocks = field.blocks;
  const std::size_t each = amounts.size() > 1 ? 1 : 0;
  const float inv_h = 1.0f / cell_size, scale = cell_size / width;
  std::vector<float> weight;
  for (std::size_t p = 0; p < x.size(); ++p) {
    const Vec3f q = x[p] * inv_h;
    if (!(std::abs(q.x) < 1e9f && std::abs(q.y) < 1e9f && std::abs(q.z) < 1e9f)) continue;
    const Mat3f stretch = S(p), back = symmetric_inverse(stretch);
    std::int32_t low[3], count[3];
    for (int a = 0; a < 3; ++a) {
      const float reach = std::min(kernel_reach(stretch, a) / scale, most_kernel_cells);
      low[a] = std::int32_t(std::ceil(q[a] - reach - 0.5f));
      count[a] = std::int32_t(std::floor(q[a] + reach - 0.5f)) - low[a] + 1;
    }
    weight.assign(std::size_t(std::max(count[0], 0)) * std::size_t(std::max(count[1], 0)) *
                      std::size_t(std::max(count[2], 0)),
                  0.0f);
    float sum = 0;
    std::size_t n = 0;
    for (int i = 0; i < count[0]; ++i)
      for (int j = 0; j < count[1]; ++j)
        for (int k = 0; k < count[2]; ++k, ++n) {
          const Vec3f cell{float(low[0] + i) + 0.5f, float(low[1] + j) + 0.5f, float(low[2] + k) + 0.5f};
          const Vec3f u = back * (cell - q) * scale;
          weight[n] = spline(u.x) * spline(u.y) * spline(u.z);
          sum += weight[n];
        }
    if (!(sum > 0)) {  // a kernel so thin that it meets no middle of a cell: all in its own
      for (int a = 0; a < 3; ++a) low[a] = std::int32_t(std::floor(q[a])), count[a] = 1;
      weight.assign(1, 1.0f);
      sum = 1;
    }
    Int3 last{INT32_MAX, 0, 0};
    int block = -1;
    n = 0;
    for (int i = low[0]; i < low[0] + count[0]; ++i)
      for (int j = low[1]; j < low[1] + count[1]; ++j)
        for (int k = low[2]; k < low[2] + count[2]; ++k, ++n) {
          if (weight[n] == 0) continue;
          const Int3 at{i >> Blocks::shift, j >> Blocks::shift, k >> Blocks::shift};
          if (!(at == last)) block = blocks.require(at);
          last = at;
          blocks.values(block)[Blocks::at(i & Blocks::mask, j & Blocks::mask, k & Blocks::mask)] +=
              amounts[each * p] * weight[n] / sum;
        }
  }
  for (int b = 0; b < blurs; ++b) field = blurred(field);
  field.blocks.close();
  return field;
}

}  // namespace neve::surface
