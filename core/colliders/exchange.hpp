// What snow and solids give each other in contact: the bookkeeping of momentum and energy.
#pragma once

#include <vector>

#include "math/mat3.hpp"

namespace neve {

struct Exchange {
  double impulse[3] = {0, 0, 0};  // of the snow on the solid [N s]
  double moment[3] = {0, 0, 0};   // of that impulse about the solid's centre [N m s]
  double energy = 0;              // kinetic energy that the contact gave to the snow [J]; negative: took

  void add(const Exchange& o) {
    for (int k = 0; k < 3; ++k) impulse[k] += o.impulse[k], moment[k] += o.moment[k];
    energy += o.energy;
  }
};

// Exchanges of one block of nodes or one home with the solids near it, by the solid's index.
class Ledger {
 public:
  void clear() { entries_.clear(); }
  Exchange& of(int solid) {
    for (auto& [index, exchange] : entries_) {
      if (index == solid) return exchange;
    }
    return entries_.emplace_back(solid, Exchange{}).second;
  }
  void add_to(std::vector<Exchange>& by_solid) const {
    for (const auto& [index, exchange] : entries_) by_solid[static_cast<std::size_t>(index)].add(exchange);
  }

 private:
  std::vector<std::pair<int, Exchange>> entries_;
};

// Book the change of velocity of masses m at x, in double, lane after lane: sums do not depend on the threads.
template <class R, class M>
inline void book(Exchange& sum, const M& mask, R m, const Vec3<R>& arm, const Vec3<R>& before,
                 const Vec3<R>& after) {
  for (int l = 0; l < width<R>; ++l) {
    if (!mask[l]) continue;
    double dp[3], a[3], energy = 0;
    for (int k = 0; k < 3; ++k) {
      const double v = before[k][l], w = after[k][l];
      dp[k] = double(m[l]) * (w - v);
      a[k] = arm[k][l];
      energy += 0.5 * dp[k] * (w + v);
    }
    for (int k = 0; k < 3; ++k) {
      sum.impulse[k] -= dp[k];
      sum.moment[k] -= a[(k + 1) % 3] * dp[(k + 2) % 3] - a[(k + 2) % 3] * dp[(k + 1) % 3];
    }
    sum.energy += energy;
  }
}

}  // namespace neve
