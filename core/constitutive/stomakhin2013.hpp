// Snow of Stomakhin et al. 2013, sections 5-6: fixed corotated elasticity, plastic flow beyond two critical strains,
// and hardening with plastic compression.
//
//   Psi = mu ||F_E - R_E||^2 + lam/2 (J_E - 1)^2,      mu, lam = (mu0, lam0) exp(xi (1 - J_P))
//   tau = 2 mu (F_E - R_E) F_E^T + lam (J_E - 1) J_E I,  in the frame of U:  tau_k = 2 mu (s_k - 1) s_k + lam (J - 1) J
//   flow: sigma <- clamp(sigma, [1 - theta_c, 1 + theta_s]),  J_P <- J_P prod(sigma_trial / sigma)
//
// J_P is bounded, which the paper does not do. From below by J_P_min inside the exponent only: J_P = 0.3 would multiply
// the stiffness by exp(7) = 1100 and shrink the time step 33 times, for a compaction past solid ice (400 kg/m3 / 917
// kg/m3 = 0.44); the state keeps the true J_P, since F_E F_P = F must hold
// (a step so long that it turns F inside out leaves J_P < 0: such a step should not have been taken). From above by J_P_max in the state too: a
// grain that flies alone keeps its affine velocity, so its "expansion" grows exponentially and means nothing; without
// the bound it overflows. At 20 the stiffness is long gone (exp(-190)), so the bound moves nothing that can be seen.
#pragma once

#include "constitutive/law.hpp"

namespace neve {

struct Stomakhin2013 {
  template <class R>
  struct Parameters {
    R mu0, lam0, xi, theta_c, theta_s, J_P_min, J_P_max;
  };

  template <class R>
  static Parameters<R> parameters(const Snow& snow, R stiffness, R strength) {
    using T = scalar_t<R>;
    const double mu = snow.E0 / (2 * (1 + snow.nu));
    const double lam = snow.E0 * snow.nu / ((1 + snow.nu) * (1 - 2 * snow.nu));
    if (!snow.plastic) {  // elastic alone: no stretch flows, nothing hardens
      const R never = splat<R>(std::numeric_limits<T>::max());
      return {stiffness * T(mu), stiffness * T(lam), R{}, never, never, splat<R>(1), splat<R>(1)};
    }
    return {stiffness * T(mu),          stiffness * T(lam),         splat<R>(T(snow.xi)),
            strength * T(snow.theta_c), strength * T(snow.theta_s), splat<R>(T(snow.J_P_min)),
            splat<R>(T(snow.J_P_max))};
  }

  template <class R>
  static R hardening(R J_P, const Parameters<R>& q) {
    return exp(q.xi * (scalar_t<R>(1) - clamp(J_P, q.J_P_min, q.J_P_max)));
  }

  // J - 1 from the principal strains, without the cancellation of the product.
  template <class R>
  static R volume_change(const Vec3<R>& e) {
    return e.x + e.y + e.z + e.x * e.y + e.x * e.z + e.y * e.z + e.x * e.y * e.z;
  }

  template <class R>
  static Stress<R> principal_stress(const Mat3<R>& U, const Vec3<R>& strain, R J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const R h = hardening(J_P, q);
    const R mu = q.mu0 * h, lam = q.lam0 * h;
    const R dJ = volume_change(strain);
    const R pressure = lam * dJ * (T(1) + dJ);
    Sym3<R> tau{pressure, pressure, pressure, splat<R>(0), splat<R>(0), splat<R>(0)};
    for (int k = 0; k < 3; ++k) {
      const Vec3<R>& u = U.column(k);
      const Vec3<R> t = u * (T(2) * mu * strain[k] * (T(1) + strain[k]));
      tau.xx += t.x * u.x;
      tau.yy += t.y * u.y;
      tau.zz += t.z * u.z;
      tau.xy += t.x * u.y;
      tau.xz += t.x * u.z;
      tau.yz += t.y * u.z;
    }
    return {tau, lam + T(2) * mu};
  }

  template <class R>
  static Stress<R> stress(const Mat3<R>& F_E, R J_P, const Parameters<R>& q) {
    const Svd3<R> svd = svd3<false>(F_E);
    return principal_stress(svd.U, svd.strain, J_P, q);
  }

  template <class R>
  static Mapped<R> return_map(const Mat3<R>& F_trial, R J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const Svd3<R> svd = svd3<false>(F_trial);
    const Vec3<R> low{clamp(svd.strain.x, -q.theta_c, q.theta_s), clamp(svd.strain.y, -q.theta_c, q.theta_s),
                      clamp(svd.strain.z, -q.theta_c, q.theta_s)};
    const Vec3<R> excess = svd.strain - low;
    Mapped<R> out{F_trial, J_P, {}};
    if (any((excess.x != T(0)) | (excess.y != T(0)) | (excess.z != T(0)))) {
      for (int k = 0; k < 3;
           ++k) {  // F_E - U diag(excess) V^T: lanes that did not flow keep F_trial to the bit
        const Vec3<R> u = svd.U.column(k) * excess[k];
        out.F_E.c0 = out.F_E.c0 - u * svd.V.column(k).x;
        out.F_E.c1 = out.F_E.c1 - u * svd.V.column(k).y;
        out.F_E.c2 = out.F_E.c2 - u * svd.V.column(k).z;
        out.J_P = out.J_P * select(excess[k] != T(0), svd.sigma[k] / (T(1) + low[k]), splat<R>(1));
      }
    }
    out.J_P = min(q.J_P_max, out.J_P);  // in this order a NaN stays one
    out.stress = principal_stress(svd.U, low, out.J_P, q);
    return out;
  }

  template <class R>
  static R energy(const Mat3<R>& F_E, R J_P, const Parameters<R>& q) {
    const Svd3<R> svd = svd3<false>(F_E);
    const R h = hardening(J_P, q);
    const R dJ = volume_change(svd.strain);
    return h * (q.mu0 * dot(svd.strain, svd.strain) + scalar_t<R>(0.5) * q.lam0 * dJ * dJ);
  }
};

}  // namespace neve
