// Which particles lie so deep in snow that no grain of theirs can show.
#pragma once

#include <vector>

#include "render/density.hpp"

namespace neve::render {

// Looks from a particle towards the eye, at places up to `reach` cells away. Where all blocks that these can
// lie in are full of snow, the particle's block knows that before.
class Burial {
 public:
  Burial(const Density& snow, Vec3f eye)
      : snow_(snow), eye_(eye), full_(std::size_t(level().count())), deep_(full_.size()) {
    const int n = level().count();
#pragma omp parallel for schedule(static)
    for (int b = 0; b < n; ++b) full_[std::size_t(b)] = full_cells(b);
#pragma omp parallel for schedule(static)
    for (int b = 0; b < n; ++b) deep_[std::size_t(b)] = is_full(b) && full_ahead(b);
    around_.resize(deep_.size());
#pragma omp parallel for schedule(static)
    for (int b = 0; b < n; ++b) around_[std::size_t(b)] = deep_beside(b);
  }

  // Whether the block around p says that p is buried; if not, it may be.
  bool deep(Vec3f p) const {
    const int block = level().holding(p);
    return block >= 0 && deep_[std::size_t(block)];
  }
  // The same of a particle whose stencil begins in block `home`, -1: none. p: its place
  bool deep(Vec3f p, int home) const {
    const Around around = home < 0 ? Around::none : around_[std::size_t(home)];
    return around == Around::all || (around == Around::some && deep(p));
  }

  // Say whether so much snow lies between p and the eye that no grain of p can show.
  bool buried(Vec3f p) const {
    if (!full_at(p)) return false;
    const Vec3f step = normalize(eye_ - p) * snow_.cell_size();
    for (float far : {reach, 1.0f, 2.2f, 3.4f})  // the farthest first, which tells most of those that are not
      if (!full_at(p + step * far)) return false;
    return true;
  }

 private:
  static constexpr float full = 0.55f;  // volume fraction of snow that hides what is behind it
  static constexpr float reach = 4.6f;  // [cells]

  const Blocks& level() const { return snow_.level(0); }

  bool full_at(Vec3f p) const {
    int cell;
    const int block = level().holding(p, cell);
    return block >= 0 && ((full_[std::size_t(block)] >> cell & 1) || snow_.sample(p) >= full);
  }
  bool is_full(int b) const { return full_[std::size_t(b)] == ~std::uint64_t(0); }

  // The cells of block b, a bit each, in which any sample is full; one between full cells may be less by a rounding.
  std::uint64_t full_cells(int b) const {
    constexpr int side = Blocks::side, ends = side + 1;
    const float* v = level().values(b);
    std::uint32_t row[ends][ends];  // bits along the last axis: of cells that are full at both of its ends
    for (int i = 0; i < ends; ++i)
      for (int j = 0; j < ends; ++j) {
        std::uint32_t points = 0;
        for (int k = 0; k < ends; ++k) points |= std::uint32_t(v[Blocks::at(i, j, k)] > 1.00001f * full) << k;
        row[i][j] = points & points >> 1;
      }
    std::uint64_t cells = 0;
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j) {
        const std::uint32_t all = row[i][j] & row[i][j + 1] & row[i + 1][j] & row[i + 1][j + 1];
        cells |= std::uint64_t(all & ((1u << side) - 1)) << (i * side + j) * side;
      }
    return cells;
  }

  // How many of block b and the next along any axis are deep.
  enum class Around : std::uint8_t { none, some, all };
  Around deep_beside(int b) const {
    const Int3 w = level().where(b);
    int deep = 0;
    for (int side = 0; side < 8; ++side) {
      const int there = level().find({w.x + (side & 1), w.y + (side >> 1 & 1), w.z + (side >> 2)});
      deep += there >= 0 && deep_[std::size_t(there)];
    }
    return deep == 0 ? Around::none : deep == 8 ? Around::all : Around::some;
  }

  // Whether all blocks are full in which a place may lie that is looked at from block b.
  bool full_ahead(int b) const {
    constexpr float half = 0.5f * Blocks::side;
    const Int3 w = level().where(b);
    const Vec3f middle = Vec3f{float(w.x), float(w.y), float(w.z)} * float(Blocks::side) +
                         Vec3f{half + 0.5f, half + 0.5f, half + 0.5f};
    const Vec3f to_eye = eye_ * (1.0f / level().cell_size()) - middle;  // [cells]
    const float nearest = std::max(length(to_eye) - 1.75f * half, 1e-6f);
    const Range x(to_eye.x, nearest), y(to_eye.y, nearest), z(to_eye.z, nearest);
    for (int i = x.first; i <= x.last; ++i)
      for (int j = y.first; j <= y.last; ++j)
        for (int k = z.first; k <= z.last; ++k) {
          const int there = level().find({w.x + i, w.y + j, w.z + k});
          if (there < 0 || !is_full(there)) return false;
        }
    return true;
  }

  // Blocks ahead along one axis, from the block itself.
  struct Range {
    int first, last;

    // to_eye: from the middle of the block [cells]; nearest: distance of the eye from the block, or less
    Range(float to_eye, float nearest) {
      constexpr float half = 0.5f * Blocks::side;
      const float share = std::min((std::abs(to_eye) + half) / nearest, 1.0f);
      const int blocks = 1 + int((reach * share + 0.1f) / Blocks::side);
      first = to_eye > half ? 0 : -blocks;
      last = to_eye < -half ? 0 : blocks;
    }
  };

  const Density& snow_;
  Vec3f eye_;
  // Of each block:
  std::vector<std::uint64_t> full_;  // see full_cells
  std::vector<std::uint8_t> deep_;
  std::vector<Around> around_;
};

}  // namespace neve::render
