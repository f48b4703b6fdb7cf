// What a step is judged by: the extremes over particles, gathered pack by pack.
#pragma once

#include "mpm/particle_update.hpp"
#include "mpm/report.hpp"

namespace neve {

template <class R>
NEVE_INLINE R sum_of(const Vec3<R>& a) {
  return a.x + a.y + a.z;
}
template <class R>
NEVE_INLINE R sum_of(const Mat3<R>& a) {
  return sum_of(a.c0 + a.c1 + a.c2);
}

// Lane by lane; `here` tells which lanes are particles.
template <class R>
struct Extremes {
  using T = scalar_t<R>;
  R wave{}, speed{}, fastest{}, rate2{}, compression{}, displacement2{},
      min_volume_ratio = splat<R>(1), ice_room = splat<R>(std::numeric_limits<T>::max());
  bool finite = true;

  // `sum` gathers all numbers of a particle: it is finite only if they all are.
  template <class M>
  NEVE_INLINE void add(const M& here, const Vec3<R>& v, R modulus, R m, R V0, const Mat3<R>& grad_v, R sum) {
    const R c = select(here, sqrt(modulus * V0 / select(m > T(0), m, splat<R>(1))), R{});
    const R s = select(here, sqrt(dot(v, v)), R{});
    const R rate = dot(grad_v.c0, grad_v.c0) + dot(grad_v.c1, grad_v.c1) + dot(grad_v.c2, grad_v.c2);
    const R all = select(here, sum + modulus, R{});
    wave = max(c, wave);
    speed = max(s, speed);
    fastest = max(c + s, fastest);
    rate2 = max(select(here, rate, R{}), rate2);
    compression = max(select(here, R(-grad_v.c0.x - grad_v.c1.y - grad_v.c2.z), R{}), compression);
    finite = finite && !any(all - all != R{});
  }

  // Add particles that have been moved; returns 1 in the lanes that make the step unacceptable.
  template <class M>
  NEVE_INLINE R add_step(const M& here, const Advanced<R>& now, R m, R V0, const StepConstants<T>& step) {
    const R sum = sum_of(now.x) + sum_of(now.v) + sum_of(now.material.F_E) + now.material.J_P +
                  now.material.stress.modulus;
    add(here, now.v, now.material.stress.modulus, m, V0, now.grad_v, sum);
    const Vec3<R>& way = now.displacement;
    const R way2 = select(here, dot(way, way) * (step.cells.gradient * step.cells.gradient), R{});
    const R volume_ratio =
        select(here, determinant(identity<R>() + scaled(now.grad_v, step.dt)), splat<R>(1));
    displacement2 = max(way2, displacement2);
    min_volume_ratio = min(volume_ratio, min_volume_ratio);
    const auto good = (sum - sum == R{}) & (way2 <= T(displacement_limit * displacement_limit)) &
                      (volume_ratio >= T(volume_ratio_limit));
    return select(here, select(good, R{}, splat<R>(1)), R{});
  }

  Report report() const {
    Report r;
    r.wave = static_cast<double>(max_lane(wave));
    r.speed = static_cast<double>(max_lane(speed));
    r.fastest = static_cast<double>(max_lane(fastest));
    r.strain_rate = std::sqrt(static_cast<double>(max_lane(rate2)));
    r.compression_rate = static_cast<double>(max_lane(compression));
    r.max_displacement = std::sqrt(static_cast<double>(max_lane(displacement2)));
    r.ice_room = -static_cast<double>(max_lane(-ice_room));
    r.min_volume_ratio = -static_cast<double>(max_lane(-min_volume_ratio));
    r.finite = finite;
    return r;
  }
};

}  // namespace neve
