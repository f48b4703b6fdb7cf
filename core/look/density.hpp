// The snow's density as light meets it: the volume fraction of snow on a pyramid of sparse grids, each level
// twice as coarse as the one before. Fine levels serve normals and shadows, coarse ones wide cones of sky.
#pragma once
#include <span>

#include "look/blocks.hpp"

namespace neve::look {

class Density {
 public:
  static constexpr int levels = 6;

  /// Spread the particles' volume over the cells with quadratic B-splines (their weights sum to one, so the grid
  /// holds what the particles hold), then average 2x2x2 cells level by level.
  /// x: positions [m]; volume: of one particle [m3]; cell_size [m]. Non-finite particles are left out.
  Density(std::span<const Vec3> x, float volume, float cell_size) {
    for (int l = 0; l < levels; ++l) level_.emplace_back(cell_size * float(1 << l));
    scatter(x, volume / (cell_size * cell_size * cell_size));
    for (int l = 1; l < levels; ++l) coarsen(level_[size_t(l - 1)], level_[size_t(l)]);
    for (Blocks& blocks : level_) blocks.close();
  }

  float cell_size() const { return level_[0].cell_size(); }
  const Blocks& level(int l) const { return level_[size_t(l)]; }
  bool empty() const { return level_[0].count() == 0; }

  float sample(Vec3 p, int l = 0) const { return level_[size_t(l)].sample(p); }

  /// Sample between two levels: a continuous level hides where one ends and the next begins.
  float sample_between(Vec3 p, float l) const {
    if (l <= 0) return sample(p, 0);
    if (l >= levels - 1) return sample(p, levels - 1);
    const int low = int(l);
    return mix(sample(p, low), sample(p, low + 1), l - float(low));
  }

  Vec3 gradient(Vec3 p, int l) const {
    const float h = level(l).cell_size();
    return Vec3{sample({p.x + h, p.y, p.z}, l) - sample({p.x - h, p.y, p.z}, l),
                sample({p.x, p.y + h, p.z}, l) - sample({p.x, p.y - h, p.z}, l),
                sample({p.x, p.y, p.z + h}, l) - sample({p.x, p.y, p.z - h}, l)} *
           (0.5f / h);
  }

  /// Volume of all the snow on a level [m3].
  double total(int l) const {
    const Blocks& blocks = level(l);
    double sum = 0;
    for (int b = 0; b < blocks.count(); ++b)
      for (int i = 0; i < Blocks::side; ++i)
        for (int j = 0; j < Blocks::side; ++j)
          for (int k = 0; k < Blocks::side; ++k) sum += double(blocks.values(b)[Blocks::at(i, j, k)]);
    const double h = blocks.cell_size();
    return sum * h * h * h;
  }

 private:
  // Cells are numbered with 32 bits; a particle beyond this many cells is drawn but throws no shadow.
  static constexpr float far_cell = 1.0e9f;

  struct Stencil {   // one axis: the first of three cells and their weights
    int32_t first;
    float w[3];
  };
  static Stencil stencil(float q) {   // q: position in cells, cell centres at i + 1/2
    const float c = std::floor(q), d = q - c - 0.5f;
    return {int32_t(c) - 1, {0.5f * (0.5f - d) * (0.5f - d), 0.75f - d * d, 0.5f * (0.5f + d) * (0.5f + d)}};
  }

  void scatter(std::span<const Vec3> x, float fraction) {
    Blocks& blocks = level_[0];
    const float inv_h = 1.0f / blocks.cell_size();
    Int3 cached{INT32_MAX, 0, 0};
    std::array<int, 8> around{};   // the blocks that a stencil beginning in `cached` may touch
    for (const Vec3& p : x) {
      const Vec3 q = p * inv_h;
      if (!(std::abs(q.x) < far_cell && std::abs(q.y) < far_cell && std::abs(q.z) < far_cell)) continue;
      const Stencil sx = stencil(q.x), sy = stencil(q.y), sz = stencil(q.z);
      const Int3 home{sx.first >> 3, sy.first >> 3, sz.first >> 3};
      if (!(home == cached)) {
        cached = home;
        around.fill(-1);
      }
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          for (int c = 0; c < 3; ++c) {
            const int i = (sx.first & 7) + a, j = (sy.first & 7) + b, k = (sz.first & 7) + c;
            const int which = (i >> 3) | (j >> 3) << 1 | (k >> 3) << 2;
            int& block = around[size_t(which)];
            if (block < 0) block = blocks.require({home.x + (i >> 3), home.y + (j >> 3), home.z + (k >> 3)});
            blocks.values(block)[Blocks::at(i & 7, j & 7, k & 7)] += fraction * sx.w[a] * sy.w[b] * sz.w[c];
          }
    }
  }

  static void coarsen(const Blocks& fine, Blocks& coarse) {
    constexpr int half = Blocks::side / 2;
    for (int f = 0; f < fine.count(); ++f) {
      const Int3 w = fine.where(f);
      float* to = coarse.values(coarse.require({w.x >> 1, w.y >> 1, w.z >> 1}));
      const float* from = fine.values(f);
      const int oi = (w.x & 1) * half, oj = (w.y & 1) * half, ok = (w.z & 1) * half;
      for (int i = 0; i < Blocks::side; ++i)
        for (int j = 0; j < Blocks::side; ++j)
          for (int k = 0; k < Blocks::side; ++k)
            to[Blocks::at(oi + i / 2, oj + j / 2, ok + k / 2)] += 0.125f * from[Blocks::at(i, j, k)];
    }
  }

  std::vector<Blocks> level_;
};

}  // namespace neve::look
