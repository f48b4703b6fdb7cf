// Units in which networks see a snow, and what they are told of it, for the laws that are learned (learned.hpp): one more
// law is one more of these. `src/neve/learned` has the same in NumPy.
#pragma once

#include "constitutive/laws.hpp"

namespace neve {

inline constexpr int most_told = 5;

// The units of a snow: of strain and its origin [1]; a factor on deviators [1]; the stiffness [Pa]; and what the network is
// told of it.
template <class R>
struct LearnedUnits {
  R strain, origin, deviator, stiffness, told[most_told];
};

// u with its deviator times c, and the same of the derivatives by it. c = 1 changes no bit.
template <class R>
Vec3<R> with_deviator(const Vec3<R>& u, const R& c) {
  const R third = (u.x + u.y + u.z) * scalar_t<R>(1.0 / 3), more = c - scalar_t<R>(1);
  return {u.x + (u.x - third) * more, u.y + (u.y - third) * more, u.z + (u.z - third) * more};
}
template <class R>
Sym3<R> with_deviator(const Sym3<R>& S, const R& c) {
  const R part = (scalar_t<R>(1) - c) * scalar_t<R>(1.0 / 3), cross = c * part;
  const R x = S.xx + S.xy + S.xz, y = S.xy + S.yy + S.yz, z = S.xz + S.yz + S.zz;
  const R all = (x + y + z) * part * part, square = c * c;
  return {square * S.xx + cross * (x + x) + all, square * S.yy + cross * (y + y) + all,
          square * S.zz + cross * (z + z) + all, square * S.xy + cross * (x + y) + all,
          square * S.xz + cross * (x + z) + all, square * S.yz + cross * (y + z) + all};
}

// How many numbers the network of a law is told; none if the law is not learned.
template <class Law>
inline constexpr int told_of = 0;
template <class Law>
inline constexpr bool is_learned = told_of<Law> > 0;

// r of the energy over the stiffness, as long as nothing else is given.
template <class Law>
inline constexpr double regularity_of = 0.1;

// Whether the energy has the hardening of the step in it, from the J_P of its start; else it is that at F0 and stays.
template <class Law>
inline constexpr bool hardens_within = false;

namespace detail {

template <class R>
R young(const R& mu, const R& lam) {
  return mu * (scalar_t<R>(3) * lam + scalar_t<R>(2) * mu) / (lam + mu);
}
}  // namespace detail

template <>
inline constexpr int told_of<Stomakhin2013> = 3;

// The strain at which snow yields is one unit.
template <class R>
LearnedUnits<R> learned_units(Stomakhin2013, const Stomakhin2013::Parameters<R>& q, const R& J_P,
                              const Vec3<R>&) {
  using T = scalar_t<R>;
  const R low = log1p(-q.theta_c), high = log1p(q.theta_s);
  const R s = T(0.5) * (high - low), origin = T(0.5) * (high + low);
  const R nu = T(0.5) * q.lam0 / (q.lam0 + q.mu0);
  return {s,
          origin,
          splat<R>(1),
          detail::young(q.mu0, q.lam0) * Stomakhin2013::hardening(J_P, q),
          {origin / s, T(20) * s, T(4) * (nu - T(0.2))}};
}

template <>
inline constexpr int told_of<CamClay> = 5;
template <>
inline constexpr double regularity_of<CamClay> = 0.02;
template <>
inline constexpr bool hardens_within<CamClay> = true;

// Deviators are measured in the ellipse's own shape, so that every ellipse looks like a circle, and all strains in the unit
// sqrt(s^2 + |e0|^2), s = p0 / K at the start of the step and e0 the strains at F0: snow that has softened yields at
// strains of 1e-6, and does with strains of 1e-3 what it does with 1e-2.
template <class R>
LearnedUnits<R> learned_units(CamClay, const CamClay::Parameters<R>& q, const R& J_P, const Vec3<R>& e0) {
  using T = scalar_t<R>;
  const auto h = CamClay::Hardening<R>::of(J_P, q);
  const R one = splat<R>(1), s = sinh_positive(h.bounded(h.start)), narrow = one / q.aspect;
  const Vec3<R> in_shape = with_deviator(e0, narrow);
  const R unit = sqrt(R(s * s + dot(in_shape, in_shape))), share = s / unit;
  return {unit,
          R{},
          narrow,
          q.lam + q.mu * T(2.0 / 3),
          {share, log1p(R(max(share, splat<R>(T(2e-3))) - one)) * T(1.0 / 6), log1p(R(q.xi - one)),
           log1p(R(q.k - one)) * T(0.5), T(2) * q.beta}};
}

}  // namespace neve
