// The plasticity of Stomakhin et al. 2013, sections 5-6, over any elasticity: flow beyond two critical strains, and
// hardening with plastic compression.
//
//   flow:       sigma <- clamp(sigma, [1 - theta_c, 1 + theta_s]),  J_P <- J_P prod(sigma_trial / sigma)
//   hardening:  mu, lam = (mu0, lam0) exp(xi (1 - J_P))
//
// J_P is bounded, which the paper does not do. From below by J_P_min inside the exponent only: J_P = 0.3 would
// multiply the stiffness by exp(7) = 1100 and shrink the time step 33 times, for a compaction past solid ice (400
// kg/m3 / 917 kg/m3 = 0.44); the state keeps the true J_P, since F_E F_P = F must hold (a step so long that it turns
// F inside out leaves J_P < 0: such a step should not have been taken). From above by J_P_max in the state too: a
// grain that flies alone keeps its affine velocity, so its "expansion" grows exponentially and means nothing;
// without the bound it overflows. At 20 the stiffness is long gone (exp(-190)), so the bound moves nothing that can
// be seen.
//
// Without plasticity ("none") the same code has limits that no strain reaches and xi = 0: F_E = F, J_P = 1.
#pragma once

#include "constitutive/principal.hpp"

namespace neve {

template <class Elasticity>
struct SnowPlasticity {
  template <class R>
  struct Parameters {
    R mu0, lam0, xi, theta_c, theta_s, J_P_min, J_P_max;
  };

  // `strength` is a factor on both critical strains; theta_c stays below one: no stretch is clamped to zero.
  template <class R>
  static Parameters<R> parameters(const Snow& snow, R stiffness, R strength) {
    using T = scalar_t<R>;
    const Lame c = lame(snow);
    const R one = splat<R>(1), mu0 = stiffness * T(c.mu), lam0 = stiffness * T(c.lam);
    if (!snow.plastic) {
      const R never = splat<R>(std::numeric_limits<T>::max());
      return {mu0, lam0, splat<R>(0), never, never, one, one};
    }
    const T top = std::max(T(0.99), T(snow.theta_c));
    return {mu0,
            lam0,
            splat<R>(T(snow.xi)),
            min(strength * T(snow.theta_c), splat<R>(top)),
            strength * T(snow.theta_s),
            splat<R>(T(snow.J_P_min)),
            splat<R>(T(snow.J_P_max))};
  }

  template <class R>
  NEVE_INLINE static R hardening(R J_P, const Parameters<R>& q) {
    return exp(q.xi * (scalar_t<R>(1) - clamp(J_P, q.J_P_min, q.J_P_max)));
  }

  template <class R>
  NEVE_INLINE static Stress<R> principal_stress(const Mat3<R>& U, const Vec3<R>& strain, R J_P,
                                                const Parameters<R>& q) {
    const R h = hardening(J_P, q);
    return in_frame(U, Elasticity::respond(strain, R(q.mu0 * h), R(q.lam0 * h)));
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
    const Vec3<R> kept{clamp(svd.strain.x, R(-q.theta_c), q.theta_s),
                       clamp(svd.strain.y, R(-q.theta_c), q.theta_s),
                       clamp(svd.strain.z, R(-q.theta_c), q.theta_s)};
    const Vec3<R> excess = svd.strain - kept;
    Mapped<R> out{F_trial, J_P, {}};
    if (any((excess.x != T(0)) | (excess.y != T(0)) | (excess.z != T(0)))) {
      out.F_E = without(F_trial, svd, excess);
      for (int k = 0; k < 3; ++k)
        out.J_P = out.J_P * select(excess[k] != T(0), R(svd.sigma[k] / (T(1) + kept[k])), splat<R>(1));
    }
    out.J_P = min(q.J_P_max, out.J_P);  // in this order a NaN stays one
    out.stress = principal_stress(svd.U, kept, out.J_P, q);
    return out;
  }

  template <class R>
  static R energy(const Mat3<R>& F_E, R J_P, const Parameters<R>& q) {
    const Svd3<R> svd = svd3<false>(F_E);
    return hardening(J_P, q) * Elasticity::energy(svd.strain, q.mu0, q.lam0);
  }
};

}  // namespace neve
