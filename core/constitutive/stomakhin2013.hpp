// Snow of Stomakhin et al. 2013, sections 5-6: fixed corotated elasticity under the snow plasticity.
//
//   Psi = mu ||F_E - R_E||^2 + lam/2 (J_E - 1)^2
//   tau = 2 mu (F_E - R_E) F_E^T + lam (J_E - 1) J_E I,  in the frame of U:  tau_k = 2 mu (s_k - 1) s_k + lam (J - 1) J
//
// Along a wave with spatial direction n and polarisation a, ||F||^2 gives 2 mu |F^T n|^2, the norm ||R|| takes from it
// (the sum of the singular values is convex), and J is linear: hence the largest modulus 2 mu s_max^2 + lam J^2.
#pragma once

#include "constitutive/snow_plasticity.hpp"

namespace neve {

struct FixedCorotated {
  template <class R>
  NEVE_INLINE static Response<R> respond(const Vec3<R>& e, R mu, R lam) {
    using T = scalar_t<R>;
    const R dJ = volume_change(e), J = T(1) + dJ, top = T(1) + largest(e), two_mu = T(2) * mu;
    return {lam * dJ * J,
            {two_mu * e.x * (T(1) + e.x), two_mu * e.y * (T(1) + e.y), two_mu * e.z * (T(1) + e.z)},
            two_mu * top * top + lam * J * J};
  }

  // 2 mu (V^2 - V) + lam (J - 1) J I.
  template <class R>
  NEVE_INLINE static Stress<R> small_response(const SmallStrain<R>& at, R mu, R lam) {
    using T = scalar_t<R>;
    const R dJ2 = at.square_volume_change(), J2 = T(1) + dJ2, J = J2 * rsqrt(J2), two_mu = T(2) * mu;
    const R isotropic = lam * (dJ2 * J * reciprocal(R(T(1) + J)));
    return {isotropic + times(at.less_root(), two_mu), two_mu * (T(1) + at.largest()) + lam * J2};
  }

  template <class R>
  NEVE_INLINE static R energy(const Vec3<R>& e, R mu, R lam) {
    const R dJ = volume_change(e);
    return mu * dot(e, e) + scalar_t<R>(0.5) * lam * dJ * dJ;
  }

  // m = 2 mu - lam (J - 1) s_k,   p = 2 mu (e_i + e_j) / (s_i + s_j) + lam (J - 1) s_k; of a reflection, s_i + s_j = 0, the
  // energy has a kink, and p no bound.
  template <class R>
  static Tangent<R> tangent(const Vec3<R>& e, R mu, R lam) {
    using T = scalar_t<R>;
    const R two_mu = T(2) * mu, zero = splat<R>(0), least = splat<R>(T(least_stretch)),
            sum = T(2) + e.x + e.y + e.z;
    Tangent<R> t{{two_mu, two_mu, two_mu, zero, zero, zero}, {two_mu, two_mu, two_mu}, {}};
    for (int k = 0; k < 3; ++k) {
      const R pair = max(sum - e[k], least);
      t.p[k] = two_mu * (pair - T(2)) / pair;
    }
    add_volume(t, Vec3<R>{T(1) + e.x, T(1) + e.y, T(1) + e.z}, R(lam * volume_change(e)), lam);
    return t;
  }
};

struct Stomakhin2013 : SnowPlasticity<FixedCorotated> {
  static constexpr Word word{"stomakhin2013", "fixed corotated elasticity, which crushes, tears and hardens",
                             "Stomakhin et al. 2013 (as quoted in public codes)", "stomakhin2013"};
};

}  // namespace neve
