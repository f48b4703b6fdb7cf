// A scalar on a sparse grid of cells, made from points or from balls.
#pragma once

#include "render/blocks.hpp"

namespace neve::surface {

using namespace render;  // vectors and blocks

// The value of cell (i, j, k) stands at origin + (i + 1/2, j + 1/2, k + 1/2) cell_size. It is ready to be sampled.
struct Field {
  Blocks blocks;
  Vec3f origin{};

  float sample(Vec3f p) const { return blocks.sample(p - origin); }
};

// Return the grid blurred with the weights (1, 2, 1) / 4 along each axis, of variance cell_size^2 / 2.
// A block of four cells reaches six: written from the first of them on, they fit into the room of a block.
inline Field blurred(const Field& field) {
  constexpr int side = Blocks::side, stride = Blocks::stride;
  constexpr float weight[3] = {0.25f, 0.5f, 0.25f};
  const float h = field.blocks.cell_size();
  Field out{Blocks(h), field.origin - Vec3f{h, h, h}};
  const int n = field.blocks.count();
  for (int b = 0; b < n; ++b) out.blocks.require(field.blocks.where(b));
#pragma omp parallel for schedule(static)
  for (int b = 0; b < n; ++b) {
    const float* from = field.blocks.values(b);
    float along[stride][side][side] = {}, across[stride][stride][side] = {};
    for (int i = 0; i < side; ++i)
      for (int d = 0; d < 3; ++d)
        for (int j = 0; j < side; ++j)
          for (int k = 0; k < side; ++k) along[i + d][j][k] += weight[d] * from[Blocks::at(i, j, k)];
    for (int i = 0; i < stride; ++i)
      for (int j = 0; j < side; ++j)
        for (int d = 0; d < 3; ++d)
          for (int k = 0; k < side; ++k) across[i][j + d][k] += weight[d] * along[i][j][k];
    float* to = out.blocks.values(b);
    for (int i = 0; i < stride; ++i)
      for (int j = 0; j < stride; ++j)
        for (int k = 0; k < side; ++k)
          for (int d = 0; d < 3; ++d) to[Blocks::at(i, j, k + d)] += weight[d] * across[i][j][k];
  }
  out.blocks.fold();
  return out;
}

// Spread amounts of points over cells with quadratic B-splines, and blur that `blurs` times.
// x: positions [m]; amounts: one for each point, or a single one for all.
inline Field of_points(std::span<const Vec3f> x, std::span<const float> amounts, float cell_size, int blurs) {
  Field field{Blocks(cell_size)};
  const std::size_t each = amounts.size() > 1 ? 1 : 0;
  scatter(field.blocks, x, [&](std::size_t p) { return amounts[each * p]; });
  for (int b = 0; b < blurs; ++b) field = blurred(field);
  field.blocks.close();
  return field;
}

// Density and momentum of points on the same blocks.
struct Moments {
  Field density;
  std::vector<Blocks> flow;  // of x, y and z
};

// Spread amounts of points, and amounts times velocities v, over cells with quadratic B-splines. What belongs to one
// point alone is spread once: its cell and its weights serve all.
inline Moments moments(std::span<const Vec3f> x, std::span<const float> amounts, std::span<const Vec3f> v,
                       float cell_size) {
  Moments out{{Blocks(cell_size)}, {}};
  Blocks& density = out.density.blocks;
  const std::size_t each = amounts.size() > 1 ? 1 : 0;
  const float inv_h = 1.0f / cell_size;
  const Groups groups = grouped(density, x);
  each_point(groups,
             [&](int b, std::uint32_t p) { add_point(density.values(b), x[p] * inv_h, amounts[each * p]); });
  density.fold();
  density.close();
  out.flow.assign(3, density.zeros());
  each_point(groups, [&](int b, std::uint32_t p) {
    const Vec3f flow = v[p] * amounts[each * p];
    const Vec3f q = x[p] * inv_h;
    const Stencil sx(q.x), sy(q.y), sz(q.z);
    const int at = Blocks::at(sx.first & Blocks::mask, sy.first & Blocks::mask, sz.first & Blocks::mask);
    float* to[3] = {out.flow[0].values(b) + at, out.flow[1].values(b) + at, out.flow[2].values(b) + at};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          const float w = sx.w[i] * sy.w[j] * sz.w[k];
          for (int c = 0; c < 3; ++c) to[c][Blocks::at(i, j, k)] += w * flow[c];
        }
  });
  for (Blocks& flow : out.flow) flow.fold();
  return out;
}

// Weight of a metaball at the squared distance q from its centre, in radii squared: 1 - 22/9 q + 17/9 q^2 - 4/9 q^3
// (Wyvill et al. 1986), from 1 in the centre to 0 with zero slope at one radius.
template <class R>
R wyvill(R q) {
  return q < R(1) ? R(1) + q * (R(-22) + q * (R(17) - R(4) * q)) / R(9) : R(0);
}

// Add up balls of the radius `radius` [m] at the centres of cells: sum_p amount_p wyvill(|x - x_p|^2 / radius^2).
inline Field of_balls(std::span<const Vec3f> x, std::span<const float> amounts, float radius,
                      float cell_size) {
  Field field{Blocks(cell_size)};
  Blocks& blocks = field.blocks;
  const std::size_t each = amounts.size() > 1 ? 1 : 0;
  const float inv_h = 1.0f / cell_size, reach = radius * inv_h;
  const auto low = [&](float q) { return std::int32_t(std::ceil(q - reach - 0.5f)); };
  const auto high = [&](float q) { return std::int32_t(std::floor(q + reach - 0.5f)); };
  for (std::size_t p = 0; p < x.size(); ++p) {
    const Vec3f q = x[p] * inv_h;
    if (!(std::abs(q.x) < 1e9f && std::abs(q.y) < 1e9f && std::abs(q.z) < 1e9f)) continue;
    Int3 last{INT32_MAX, 0, 0};
    int block = -1;
    for (std::int32_t i = low(q.x); i <= high(q.x); ++i)
      for (std::int32_t j = low(q.y); j <= high(q.y); ++j)
        for (std::int32_t k = low(q.z); k <= high(q.z); ++k) {
          const Vec3f d = Vec3f{float(i) + 0.5f, float(j) + 0.5f, float(k) + 0.5f} - q;
          const float value = wyvill(dot(d, d) / (reach * reach));
          if (value <= 0) continue;
          const Int3 at{i >> Blocks::shift, j >> Blocks::shift, k >> Blocks::shift};
          if (!(at == last)) block = blocks.require(at);
          last = at;
          blocks.values(block)[Blocks::at(i & Blocks::mask, j & Blocks::mask, k & Blocks::mask)] +=
              amounts[each * p] * value;
        }
  }
  blocks.close();
  return field;
}

}  // namespace neve::surface
