// Neo-Hookean elasticity under the snow plasticity.
//
//   Psi = mu/2 (||F_E||^2 - 3) - mu ln J + lam/2 ln^2 J
//   tau = mu (F_E F_E^T - I) + lam ln J I,  in the frame of U:  tau_k = mu (s_k^2 - 1) + lam ln J
//
// Along a wave the second derivative is mu |F^T n|^2 + (mu + lam (1 - ln J)) (a . n)^2, largest along the longest axis.
#pragma once

#include "constitutive/snow_plasticity.hpp"

namespace neve {

struct NeoHookeanElasticity {
  template <class R>
  NEVE_INLINE static R log_volume(const Vec3<R>& e) {
    return log1p(max(volume_change(e), splat<R>(scalar_t<R>(least_stretch - 1))));
  }

  template <class R>
  NEVE_INLINE static Response<R> respond(const Vec3<R>& e, R mu, R lam) {
    using T = scalar_t<R>;
    const R ln_J = log_volume(e), top = T(1) + largest(e);
    return {lam * ln_J,
            {mu * e.x * (T(2) + e.x), mu * e.y * (T(2) + e.y), mu * e.z * (T(2) + e.z)},
            mu * top * top + max(mu + lam * (T(1) - ln_J), splat<R>(0))};
  }

  // mu B + lam ln J I.
  template <class R>
  NEVE_INLINE static Stress<R> small_response(const SmallStrain<R>& at, R mu, R lam) {
    using T = scalar_t<R>;
    const R ln_J = T(0.5) * log1p(at.square_volume_change());
    return {lam * ln_J + times(at.B, mu),
            mu * (T(1) + at.largest()) + max(R(mu + lam * (T(1) - ln_J)), splat<R>(0))};
  }

  template <class R>
  NEVE_INLINE static R energy(const Vec3<R>& e, R mu, R lam) {
    using T = scalar_t<R>;
    const R ln_J = log_volume(e);
    return mu * (e.x + e.y + e.z + T(0.5) * dot(e, e) - ln_J) + T(0.5) * lam * ln_J * ln_J;
  }

  // With a = mu - lam ln J:  Psi_ij = (mu + a / s_i^2) delta_ij + lam / (s_i s_j),   m, p = mu +- a / (s_i s_j).
  template <class R>
  static Tangent<R> tangent(const Vec3<R>& e, R mu, R lam) {
    using T = scalar_t<R>;
    const R ln_J = log_volume(e), a = mu - lam * ln_J, least = splat<R>(T(least_stretch)), one = splat<R>(1);
    const auto inverse = [&](const R& strain) { return one / max(R(one + strain), least); };
    const Vec3<R> r{inverse(e.x), inverse(e.y), inverse(e.z)};
    const R b = lam + a;
    Tangent<R> t{{mu + b * r.x * r.x, mu + b * r.y * r.y, mu + b * r.z * r.z, lam * r.x * r.y,
                  lam * r.x * r.z, lam * r.y * r.z},
                 {},
                 {}};
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const R pair = r[i] * r[j];
      t.m[k] = mu + a * pair;
      t.p[k] = (mu * (e[i] + e[j] + e[i] * e[j]) + lam * ln_J) * pair;
    }
    return t;
  }
};

struct NeoHookean : SnowPlasticity<NeoHookeanElasticity> {
  static constexpr Word word{
      "neo_hookean",
      "Neo-Hookean elasticity, whose resistance to compression has no bound, under the same plasticity",
      "Sifakis and Barbic 2012 (as quoted in public codes)", "sifakis2012"};
};

}  // namespace neve
