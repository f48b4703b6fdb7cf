// Momentum and energy that snow and solids exchange in contact.
#pragma once

#include "math/mat3.hpp"
#if !defined(__CUDACC_RTC__)
#include <vector>
#endif

namespace neve {

struct Exchange {
  double impulse[3] = {0, 0, 0};  // of the snow on the solid [N s]
  double moment[3] = {0, 0, 0};   // of that impulse about the solid's centre [N m s]
  double work = 0;  // of the solid on the snow [J]: impulse on the snow times the solid's velocity

  void add(const Exchange& o) {
    for (int k = 0; k < 3; ++k) impulse[k] += o.impulse[k], moment[k] += o.moment[k];
    work += o.work;
  }
};

#if !defined(__CUDACC_RTC__)
// Exchanges of one block of nodes or one home with the solids near it, by the solid's index.
class ExchangeSum {
 public:
  void clear() { entries_.clear(); }
  Exchange& of(int solid) {
    for (auto& [index, exchange] : entries_) {
      if (index == solid) return exchange;
    }
    return entries_.emplace_back(solid, Exchange{}).second;
  }
  // Call f(solid, exchange) for each solid.
  template <class F>
  void each(F&& f) const {
    for (const auto& [index, exchange] : entries_) f(index, exchange);
  }
  void add_to(std::vector<Exchange>& by_solid) const {
    each([&](int solid, const Exchange& exchange) { by_solid[std::size_t(solid)].add(exchange); });
  }

 private:
  std::vector<std::pair<int, Exchange>> entries_;
};
#endif

namespace detail {

// Lane l of a pack or of a mask; of a scalar, the scalar.
template <class M>
NEVE_INLINE auto at_lane(const M& a, int l) {
  if constexpr (IsScalar<M>) {
    return a;
  } else {
    return a[l];
  }
}

}  // namespace detail

// Record an impulse dp on the snow [N s], `arm` from the solid's centre, where its surface moves with v_co; in double.
inline void record_impulse(Exchange& sum, const double (&dp)[3], const double (&arm)[3],
                           const double (&v_co)[3]) {
  for (int k = 0; k < 3; ++k) {
    sum.impulse[k] -= dp[k];
    sum.work += dp[k] * v_co[k];
  }
  for (int k = 0; k < 3; ++k)
    sum.moment[k] -= arm[(k + 1) % 3] * dp[(k + 2) % 3] - arm[(k + 2) % 3] * dp[(k + 1) % 3];
}

// Record the change of velocity of masses m, `arm` from the solid's centre, on a surface that moves with v_co; in double,
// lane after lane, so that sums do not depend on the threads.
//
// The work is impulse times v_co, not the change of kinetic energy: a wall at rest does none, though it stops, in every
// step, what the snow's own stress has just set in motion.
template <class R, class M>
inline void record(Exchange& sum, const M& mask, R m, const Vec3<R>& arm, const Vec3<R>& v_co,
                   const Vec3<R>& before, const Vec3<R>& after) {
  using detail::at_lane;
  for (int l = 0; l < width<R>; ++l) {
    if (!at_lane(mask, l)) continue;
    double dp[3], from[3], with[3];
    for (int k = 0; k < 3; ++k) {
      dp[k] = double(at_lane(m, l)) * (double(at_lane(after[k], l)) - double(at_lane(before[k], l)));
      from[k] = double(at_lane(arm[k], l)), with[k] = double(at_lane(v_co[k], l));
    }
    record_impulse(sum, dp, from, with);
  }
}

}  // namespace neve
