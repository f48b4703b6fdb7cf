// The snow's density as light meets it: the volume fraction of snow on a pyramid of sparse grids, each level
// twice as coarse as the one before. Fine levels serve normals and shadows, coarse ones wide cones of sky.
#pragma once

#include <span>

#include "math/bspline.hpp"
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
    scatter(x, volume / (cell_size * cell_size * cell_size));
    for (int l = 1; l < levels; ++l) coarsen(level_[std::size_t(l - 1)], level_[std::size_t(l)]);
    for (Blocks& blocks : level_) blocks.close();
  }

  float cell_size() const { return level_[0].cell_size(); }
  const Blocks& level(int l) const { return level_[std::size_t(l)]; }
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
  // Cells are numbered with 32 bits; a particle beyond this many cells is drawn but throws no shadow.
  static constexpr float far_cell = 1.0e9f;

  struct Stencil {  // one axis: the first of three cells and their weights
    std::int32_t first;
    float w[Quadratic::nodes];
  };
  static std::int32_t begin(float q) { return std::int32_t(std::floor(q)) - 1; }
  static Stencil stencil(float q) {  // q: position in cells, cell centres at i + 1/2
    Stencil out;
    float slopes[Quadratic::nodes];
    out.first = begin(q);
    Quadratic::weights(q - std::floor(q), out.w, slopes);
    return out;
  }

  void scatter(std::span<const Vec3f> x, float fraction) {
    Blocks& blocks = level_[0];
    const float inv_h = 1.0f / blocks.cell_size();
    // Group the particles by the block in which their stencil begins; a group writes into its block only.
    std::vector<std::int32_t> home(x.size(), -1);
    std::vector<std::uint32_t> first(1, 0);
    Int3 last{INT32_MAX, 0, 0};
    int block = -1;
    for (std::size_t p = 0; p < x.size(); ++p) {
      const Vec3f q = x[p] * inv_h;
      if (!(std::abs(q.x) < far_cell && std::abs(q.y) < far_cell && std::abs(q.z) < far_cell)) continue;
      const Int3 at{begin(q.x) >> Blocks::shift, begin(q.y) >> Blocks::shift, begin(q.z) >> Blocks::shift};
      if (!(at == last)) block = blocks.require(at);
      last = at;
      home[p] = block;
      if (std::size_t(block) + 2 > first.size()) first.resize(std::size_t(block) + 2, 0);
      ++first[std::size_t(block) + 1];
    }
    for (std::size_t b = 1; b < first.size(); ++b) first[b] += first[b - 1];
    std::vector<std::uint32_t> order(first.back()), next(first);
    for (std::uint32_t p = 0; p < x.size(); ++p)
      if (home[p] >= 0) order[next[std::size_t(home[p])]++] = p;
    const int n = blocks.count();
#pragma omp parallel for schedule(dynamic, 64)
    for (int b = 0; b < n; ++b)
      for (std::uint32_t o = first[std::size_t(b)]; o < first[std::size_t(b) + 1]; ++o)
        add(blocks.values(b), x[order[o]] * inv_h, fraction);
    blocks.fold();
  }

  static void add(float* block, Vec3f q, float fraction) {
    const Stencil sx = stencil(q.x), sy = stencil(q.y), sz = stencil(q.z);
    float* v = block + Blocks::at(sx.first & Blocks::mask, sy.first & Blocks::mask, sz.first & Blocks::mask);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c) v[Blocks::at(a, b, c)] += fraction * sx.w[a] * sy.w[b] * sz.w[c];
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

}  // namespace neve::render
