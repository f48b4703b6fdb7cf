// The snow's density as light meets it: the volume fraction of snow on a pyramid of sparse grids, each level
// twice as coarse as the one before. Fine levels serve normals and shadows, coarse ones wide cones of sky.
#pragma once

#include <span>

#include "render/blocks.hpp"

namespace neve::render {

class Density {
 public:
  static constexpr int levels = 6;

  // Spread the particles' volume over the cells with quadratic B-splines (their weights sum to one, so the
  // grid holds what the particles hold), then average 2x2x2 cells level by level. x: positions [m];
  // volume: of one particle [m3]; cell_size [m]. Non-finite particles are left out.
  Density(std::span<const Vec3f> x, float volume, float cell_size) {
    for (int l = 0; l < levels; ++l) level_.emplace_back(cell_size * float(1 << l));
    const float fraction = volume / (cell_size * cell_size * cell_size);
    home_ = scatter(level_[0], x, [fraction](std::size_t) { return fraction; });
    for (int l = 1; l < levels; ++l) coarsen(level_[std::size_t(l - 1)], level_[std::size_t(l)]);
    for (Blocks& blocks : level_) blocks.close();
  }

  float cell_size() const { return level_[0].cell_size(); }
  const Blocks& level(int l) const { return level_[std::size_t(l)]; }
  // The block of level 0 in which the stencil of particle p begins, or -1: p lies in it or in the next along any axis.
  int home(std::size_t p) const { return home_[p]; }
  bool empty() const { return level_[0].count() == 0; }

  float sample(Vec3f p, int l = 0) const { return level_[std::size_t(l)].sample(p); }

  // Sample between two levels: a continuous level hides where one ends and the next begins.
  float sample_between(Vec3f p, float l) const {
    if (l <= 0) return sample(p, 0);
    if (l >= levels - 1) return sample(p, levels - 1);
    const int low = int(l);
    return mix(sample(p, low), sample(p, low + 1), l - float(low));
  }

  // Slope of the density over one cell of a level, from four samples at the corners of a tetrahedron.
  Vec3f slope(Vec3f p, int l) const {
    const float h = 0.7f * level(l).cell_size();
    const float a = sample({p.x + h, p.y + h, p.z + h}, l), b = sample({p.x + h, p.y - h, p.z - h}, l);
    const float c = sample({p.x - h, p.y + h, p.z - h}, l), d = sample({p.x - h, p.y - h, p.z + h}, l);
    return Vec3f{a + b - c - d, a - b + c - d, a - b - c + d} * (0.25f / 0.7f);
  }

  // Volume of all the snow on a level [m3].
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
  BlockOf home_;
};

}  // namespace neve::render
