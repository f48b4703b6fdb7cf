// What a solid does to a velocity that meets it (Stomakhin et al. 2013, section 8; docs/theory.md).
#pragma once

#include "math/mat3.hpp"

namespace neve {

// sticky:   snow takes the solid's velocity.
// slip:     snow never leaves nor enters the surface; Coulomb friction while it is pressed on. With friction, never
//           leaves means: by no more than the play below.
// separate: snow may leave; Coulomb friction while it is pressed on.
enum class ContactMode { sticky, slip, separate };

// Snow may leave a surface with mode slip and friction by this share of a cell.
//
// Where a surface holds snow tight, vibrations that are no larger than the snow's own weight press it by more than its
// weight and pull on it in turn. Friction feels the first only, feeds the vibration, and grows with it: several times
// mu_c times the weight. Free to leave by a hair, snow is never pulled by them, and rubs as it does in mode separate.
inline constexpr double play_cells = 0.1;

template <class T>
inline bool has_play(ContactMode mode, T mu_c) {
  return mode == ContactMode::slip && mu_c > T(0);
}

// Between which velocities along n snow is free in its play: -s / dt and (play - s) / dt for snow that has left by s.
template <class R>
struct Play {
  R least{}, most{};
};

// Where a surface faces: its unit normal n, along which it pushes, and its normal half a step on, scaled so that
// n . mid = 1; and the speed along mid that the surface has gained by then where the snow is, because it turns. Snow
// that keeps to a curved surface moves along it in the middle of the step, not at the start.
template <class R>
struct Facing {
  Vec3<R> n, mid;
  R gained;  // [m/s]
};
template <class R>
inline Facing<R> flat(const Vec3<R>& n) {
  return {n, n, R{}};
}

// The speed that the surface takes from snow that moves with v_rel: all that it has along the surface's normal half a
// step on; along n no more than an elastic bounce takes, so that kinetic energy never rises.
template <class R>
inline R normal_speed(const Vec3<R>& v_rel, const Facing<R>& facing) {
  const R bounce = dot(v_rel, facing.n) * scalar_t<R>(2);
  return clamp(R(dot(v_rel, facing.mid) - facing.gained), min(bounce, R{}), max(bounce, R{}));
}

// The velocity after contact of snow that moves with `v` at a surface that moves with `v_co`: v_n -> 0, and v_t shrinks
// by mu_c |v_n|, at most to zero. In mode slip v_n ends within the play.
template <class R>
inline Vec3<R> after_contact(const Vec3<R>& v, const Facing<R>& facing, const Vec3<R>& v_co, ContactMode mode,
                             scalar_t<R> mu_c, const Play<R>& play = {}) {
  if (mode == ContactMode::sticky) return v_co;
  using T = scalar_t<R>;
  const R zero = splat<R>(0), one = splat<R>(1);
  const Vec3<R> v_rel = v - v_co, n = facing.n;
  const R v_n = normal_speed(v_rel, facing);
  const Vec3<R> v_t = v_rel - n * v_n;
  const R speed = sqrt(dot(v_t, v_t));
  const R pressed = max(R(play.least - v_n), zero);
  const R kept = max(one - mu_c * pressed / select(speed > zero, speed, one), zero);
  const Vec3<R> slid = v_t * select(speed > zero, kept, zero) + v_co;
  if (mode == ContactMode::separate) return select(v_n < T(0), slid, v);
  return has_play(mode, mu_c) ? slid + n * clamp(v_n, play.least, play.most) : slid;
}

// The derivative of after_contact at a flat surface by v_co: how the snow's velocity changes with that of the surface.
//
// With t the direction of sliding and g = mu_c |v_n| < |v_t|: n n^T - mu_c t n^T + (g / |v_t|) (1 - n n^T - t t^T);
// the identity where the snow sticks, zero where it leaves or moves within its play. In mode slip the snow at the end
// of its play slides freely: n n^T.
template <class R>
inline Mat3<R> contact_slope(const Vec3<R>& v, const Vec3<R>& n, const Vec3<R>& v_co, ContactMode mode,
                             scalar_t<R> mu_c, const Play<R>& play = {}) {
  if (mode == ContactMode::sticky) return identity<R>();
  const R zero = splat<R>(0), one = splat<R>(1);
  const Vec3<R> v_rel = v - v_co;
  const R v_n = dot(v_rel, n);
  const Vec3<R> v_t = v_rel - n * v_n;
  const R speed = sqrt(dot(v_t, v_t)), grip = mu_c * max(R(play.least - v_n), zero);
  const auto slides = speed > grip;
  const R share = select(slides, grip / select(slides, speed, one), one);
  const Vec3<R> t = v_t * select(slides, one / select(slides, speed, one), zero);
  const R mu = select(slides & (v_n < play.least), splat<R>(mu_c), zero);
  Mat3<R> D;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      const R delta = splat<R>(i == j ? 1 : 0);
      D(i, j) = n[i] * n[j] - mu * t[i] * n[j] + share * (delta - n[i] * n[j] - t[i] * t[j]);
    }
  }
  if (mode == ContactMode::separate) return select(v_n < zero, D, scaled(D, zero));
  return has_play(mode, mu_c) ? select((v_n <= play.least) | (v_n >= play.most), D, scaled(D, zero)) : D;
}

}  // namespace neve
