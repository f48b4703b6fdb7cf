// Which particles lie so deep in snow that no grain of theirs can show.
#pragma once

#include <vector>

#include "render/density.hpp"

namespace neve::render {

// Looks from a particle towards the eye, at places up to `reach` cells away. Where all blocks that these can
// lie in are full of snow, the particle's block knows that before.
class Burial {
 public:
  Burial(const Density& snow, Vec3f eye) : snow_(snow), eye_(eye), deep_(std::size_t(level().count()), 0) {
    const int n = level().count();
    std::vector<std::uint8_t> is_full(deep_.size());
#pragma omp parallel for schedule(static)
    for (int b = 0; b < n; ++b) is_full[std::size_t(b)] = full_everywhere(b);
#pragma omp parallel for schedule(static)
    for (int b = 0; b < n; ++b) deep_[std::size_t(b)] = is_full[std::size_t(b)] && full_ahead(b, is_full);
  }

  // Whether the block around p says that p is buried; if not, it may be.
  bool deep(Vec3f p) const {
    const int block = level().holding(p);
    return block >= 0 && deep_[std::size_t(block)];
  }

  // Say whether so much snow lies between p and the eye that no grain of p can show. here: volume fraction
  // at p.
  bool buried(Vec3f p, float here) const {
    if (here < full) return false;
    const Vec3f step = normalize(eye_ - p) * snow_.cell_size();
    for (float far : {1.0f, 2.2f, 3.4f, reach})
      if (snow_.sample(p + step * far) < full) return false;
    return true;
  }

 private:
  static constexpr float full = 0.55f;  // volume fraction of snow that hides what is behind it
  static constexpr float reach = 4.6f;  // [cells]

  const Blocks& level() const { return snow_.level(0); }

  // Whether any sample in block b is full; a sample between full cells may be less by a rounding.
  bool full_everywhere(int b) const {
    const float* v = level().values(b);
    for (int i = 0; i <= Blocks::side; ++i)
      for (int j = 0; j <= Blocks::side; ++j)
        for (int k = 0; k <= Blocks::side; ++k)
          if (!(v[Blocks::at(i, j, k)] > 1.00001f * full)) return false;
    return true;
  }

  // Whether all blocks are full in which a place may lie that is looked at from block b.
  bool full_ahead(int b, const std::vector<std::uint8_t>& is_full) const {
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
          if (there < 0 || !is_full[std::size_t(there)]) return false;
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
  std::vector<std::uint8_t> deep_;  // of each block
};

}  // namespace neve::render
