// What a solid does to a velocity that meets it (Stomakhin et al. 2013, section 8; docs/theory.md).
#pragma once

#include "math/mat3.hpp"

namespace neve {

// sticky:   snow takes the solid's velocity.
// slip:     snow never leaves nor enters the surface; Coulomb friction while it is pressed on.
// separate: snow may leave; Coulomb friction while it is pressed on.
enum class ContactMode { sticky, slip, separate };

// The velocity after contact of snow that moves with `v` at a surface of unit normal n that moves with `v_co`:
// v_n -> 0, and v_t shrinks by mu_c |v_n|, at most to zero.
template <class R>
inline Vec3<R> after_contact(const Vec3<R>& v, const Vec3<R>& n, const Vec3<R>& v_co, ContactMode mode,
                             scalar_t<R> mu_c) {
  if (mode == ContactMode::sticky) return v_co;
  using T = scalar_t<R>;
  const R zero = splat<R>(0), one = splat<R>(1);
  const Vec3<R> v_rel = v - v_co;
  const R v_n = dot(v_rel, n);
  const Vec3<R> v_t = v_rel - n * v_n;
  const R speed = sqrt(dot(v_t, v_t));
  const R pressed = max(-v_n, zero);
  const R kept = max(one - mu_c * pressed / select(speed > zero, speed, one), zero);
  const Vec3<R> slid = v_t * select(speed > zero, kept, zero) + v_co;
  return mode == ContactMode::separate ? select(v_n < T(0), slid, v) : slid;
}

// The derivative of after_contact by v_co: how the snow's velocity changes with that of the surface.
//
// With t the direction of sliding and g = mu_c |v_n| < |v_t|: n n^T - mu_c t n^T + (g / |v_t|) (1 - n n^T - t t^T);
// the identity where the snow sticks, zero where it leaves.
template <class R>
inline Mat3<R> contact_slope(const Vec3<R>& v, const Vec3<R>& n, const Vec3<R>& v_co, ContactMode mode,
                             scalar_t<R> mu_c) {
  if (mode == ContactMode::sticky) return identity<R>();
  const R zero = splat<R>(0), one = splat<R>(1);
  const Vec3<R> v_rel = v - v_co;
  const R v_n = dot(v_rel, n);
  const Vec3<R> v_t = v_rel - n * v_n;
  const R speed = sqrt(dot(v_t, v_t)), grip = mu_c * max(-v_n, zero);
  const auto slides = speed > grip;
  const R share = select(slides, grip / select(slides, speed, one), one);
  const Vec3<R> t = v_t * select(slides, one / select(slides, speed, one), zero);
  const R mu = select(slides & (v_n < zero), splat<R>(mu_c), zero);
  Mat3<R> D;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      const R delta = splat<R>(i == j ? 1 : 0);
      D(i, j) = n[i] * n[j] - mu * t[i] * n[j] + share * (delta - n[i] * n[j] - t[i] * t[j]);
    }
  }
  return mode == ContactMode::separate ? select(v_n < zero, D, scaled(D, zero)) : D;
}

}  // namespace neve
