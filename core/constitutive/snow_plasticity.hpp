// The plasticity of Stomakhin et al. 2013, sections 5-6, over any elasticity: flow beyond two critical strains, and
// hardening with plastic compression.
//
//   flow:       sigma <- clamp(sigma, [1 - theta_c, 1 + theta_s]),  J_P <- J_P prod(sigma_trial / sigma)
//               unless that would make energy, which the paper does not look at (dissipative())
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
// Without plasticity ("none") the same code has xi = 0 and limits that no snow should reach: F_E = F, J_P = 1, until an
// axis is crushed to a hundredth. (Fixed corotated snow can be crushed to nothing with finite energy; F_E would become
// singular.)
#pragma once

#include "constitutive/principal.hpp"

namespace neve {

// The largest theta_c that `strength` makes, and that of snow without plasticity: no stretch is clamped to zero.
inline constexpr double most_crushing = 0.99;

// The largest xi max(theta_c, theta_s). While snow is crushed, hardening multiplies its elastic energy by
// exp(xi (1 - J_P)); the work of crushing pays for that as long as xi theta < 2/3 (small, on all axes).
inline constexpr double most_hardening = 0.5;

// The largest x with (exp(x) - 1) / x <= 2 / (3 xi theta), by bisection; 0 if there is none.
inline double affordable(double xi_theta) {
  double low = 0, high = 20;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 * (low + high);
    (std::expm1(x) / x <= 2 / (3 * xi_theta) ? low : high) = x;
  }
  return low;
}

template <class Elasticity>
struct SnowPlasticity {
  static constexpr bool has_elastic_option = true;
  static constexpr bool compacts = true;
  static constexpr const char* plasticity_cites = "stomakhin2013";
  static constexpr const char* limit =
      "so that hardening cannot create energy (xi theta_c and xi theta_s at most 0.5)";

  struct Constants : ElasticConstants {
    double xi, theta_c, theta_s, J_P_min, J_P_max;
  };
  static constexpr const char* paper = "Stomakhin et al. 2013 (as quoted in public codes)";
  static constexpr Constant<Constants> constants[] = {
      rho0_of<Constants>(400, paper),
      E0_of<Constants>(1.4e5, paper),
      nu_of<Constants>(0.2, paper),
      {"xi",
       &Constants::xi,
       10,
       "1",
       {0, 100},
       {0.1, 100.0},
       Role::plastic,
       paper,
       "Hardening; larger is more brittle."},
      {"theta_c",
       &Constants::theta_c,
       2.5e-2,
       "1",
       {0, 1, false, true},
       {1e-3, 0.9},
       Role::threshold,
       paper,
       "Critical compression, beyond which snow is crushed for good; smaller is powdery; xi times the larger "
       "of "
       "theta_c and theta_s is at most 0.5."},
      {"theta_s",
       &Constants::theta_s,
       7.5e-3,
       "1",
       {0, 1},
       {1e-3, 0.9},
       Role::threshold,
       paper,
       "Critical stretch, beyond which snow tears; smaller is powdery."},
      J_P_min_of<Constants>(0.6),
      J_P_max_of<Constants>(20),
  };

  static double most_strength(const Constants& c) {
    const double hardening = c.xi * (c.theta_c > c.theta_s ? c.theta_c : c.theta_s);
    return hardening > 0 ? most_hardening / hardening : std::numeric_limits<double>::infinity();
  }

  // Pressed by de on each axis, snow at its yield strain theta does the work w de, w = 3 (2 mu + 3 lam) theta, and
  // hardens by exp(x), x = 3 xi de, which adds w (theta / 2) (exp(x) - 1) to its energy: affordable while
  // (exp(x) - 1) / x <= 2 / (3 xi theta). On fewer axes it is cheaper (docs/theory.md).
  static double max_compression(const Constants& c, double strongest) {
    if (!(c.xi * c.theta_c > 0)) return std::numeric_limits<double>::infinity();
    return affordable(c.xi * c.theta_c * strongest) / c.xi;
  }

  static double hardening_exponent(const Constants& c) { return c.xi * (1 - c.J_P_min); }

  template <class R>
  struct Parameters {
    R mu0, lam0, xi, theta_c, theta_s, J_P_min, J_P_max;
  };

  // `strength` is a factor on both critical strains.
  template <class R>
  static Parameters<R> parameters(const Snow& snow, R stiffness, R strength) {
    using T = scalar_t<R>;
    const auto given = snow.constants<Constants>();
    const Lame& c = snow.lame;
    const R one = splat<R>(1), mu0 = stiffness * T(c.mu), lam0 = stiffness * T(c.lam);
    if (!snow.plastic) {
      return {mu0, lam0, splat<R>(0), splat<R>(T(most_crushing)), splat<R>(std::numeric_limits<T>::max()),
              one, one};
    }
    const T theta_c = T(given.theta_c);
    return {mu0,
            lam0,
            splat<R>(T(given.xi)),
            min(strength * theta_c, splat<R>(max(theta_c, T(most_crushing)))),
            strength * T(given.theta_s),
            splat<R>(T(given.J_P_min)),
            splat<R>(T(given.J_P_max))};
  }

  template <class R>
  NEVE_INLINE static R hardening(R J_P, const Parameters<R>& q) {
    return exp(q.xi * (scalar_t<R>(1) - clamp(J_P, q.J_P_min, q.J_P_max)));
  }

  // The elasticities are linear in mu and lam.
  template <class R>
  NEVE_INLINE static Response<R> hardened(const Response<R>& r, R h) {
    return {r.isotropic * h, r.axial * h, r.modulus * h};
  }

  template <class R>
  static Stress<R> stress(const Mat3<R>& F_E, R J_P, const Parameters<R>& q) {
    const Sym3<R> B = strain_of(F_E);
    if constexpr (has_small_response<R>) {
      const SmallStrain<R> small(B);
      const R most = splat<R>(scalar_t<R>(small_strain));
      if (!any(negated(small.lies_between(R(-most), most) & (determinant(F_E) > splat<R>(0)))))
        return small_elastic(F_E, small, J_P, q).stress;
    }
    return with_stretches(F_E, B, [&](const auto& at) NEVE_INLINE_LAMBDA {
      return at.stress(hardened(Elasticity::respond(at.strain, q.mu0, q.lam0), hardening(J_P, q)));
    });
  }

  // Flow that makes no energy, for strains whose way to the limits would: what the axes beyond the limit of that side
  // give goes to the axis that is farthest on the other side, and from where it meets the second one on, to both, so that
  // the volume, and with it the pressure, stays; beyond the limit on all axes snow comes apart. What axes beyond the other
  // limit flow on their way there changes the volume towards rest, and not past it.
  //
  // side: the sign of the strains that would flow against their stress. They are of one side only, stretched or pressed:
  // that which all axes share of tau presses or pulls.
  template <class R>
  NEVE_RARE static Vec3<R> dissipative(const Vec3<R>& trial, const Vec3<R>& clamped, const R& side,
                                       const Parameters<R>& q) {
    const auto stretched = side > splat<R>(0);
    const R one = splat<R>(1), limit = select(stretched, q.theta_s, R(-q.theta_c));
    Vec3<R> e, from;
    for (int k = 0; k < 3; ++k) {
      from[k] = select(stretched, max(trial[k], clamped[k]), min(trial[k], clamped[k]));
      e[k] = select(stretched, min(from[k], limit), max(from[k], limit));
    }
    const R at_first = volume_change(trial), other = volume_change(from), zero = splat<R>(0);
    const R kept = select(stretched, max(at_first, min(other, zero)), min(at_first, max(other, zero)));
    const R cut = volume_change(e), given = (kept - cut) / (one + cut);
    const R smallest = min(e.x, min(e.y, e.z)), largest = max(e.x, max(e.y, e.z));
    const R first = select(stretched, smallest, largest);
    const R second = max(min(e.x, e.y), min(max(e.x, e.y), e.z));
    const R alone = first + (one + first) * given;
    const R area = volume_change(Vec3<R>{first, second, given});
    const R shared = area / (one + sqrt(max(one + area, splat<R>(0))));  // sqrt(1 + area) - 1
    const R level = select(stretched, min(min(alone, shared), limit), max(max(alone, shared), limit));
    for (int k = 0; k < 3; ++k) e[k] = select(stretched, max(e[k], level), min(e[k], level));
    return e;
  }

  // Clamp the strains and return the response to them, at mu0 and lam0; but where that flow does work on the snow,
  // sum_k dPsi/ds_k (s'_k - s_k) < 0 with the stress at its end, flow otherwise. Snow that is pressed along one axis
  // presses on the others too, even where it is stretched beyond theta_s: flowing there, it pushes against that
  // pressure, in every step anew.
  template <class R>
  NEVE_INLINE static Response<R> flow(const Vec3<R>& trial, Vec3<R>& kept, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const R zero = splat<R>(0);
    const Response<R> at = Elasticity::respond(kept, q.mu0, q.lam0);
    R side = zero, dissipated = zero;  // times the product of the stretches
    for (int k = 0; k < 3; ++k) {
      const R flow = trial[k] - kept[k], work = flow * (at.isotropic + at.axial[k]);
      side = select(work < zero, flow, side);
      dissipated = dissipated + work * ((T(1) + kept[(k + 1) % 3]) * (T(1) + kept[(k + 2) % 3]));
    }
    const auto against = dissipated < zero;
    if (!any(against)) return at;
    kept = select(against, dissipative(trial, kept, side, q), kept);
    return Elasticity::respond(kept, q.mu0, q.lam0);
  }

  template <class R>
  static Mapped<R> return_map(const Mat3<R>& F_trial, R J_P, const Parameters<R>& q) {
    const Sym3<R> B = strain_of(F_trial);
    if constexpr (has_small_response<R>) {
      const SmallStrain<R> small(B);
      if (!any(negated(is_elastic(small, q) & (determinant(F_trial) > splat<R>(0)))))
        return small_elastic(F_trial, small, J_P, q);
    }
    return with_stretches(F_trial, B,
                          [&](const auto& trial) NEVE_INLINE_LAMBDA { return map_stretches(trial, J_P, q); });
  }

  // Whether the elasticity gives the response to a small strain without its eigenvalues:
  // Elasticity::small_response(strain, mu, lam), the stress.
  template <class R>
  static constexpr bool has_small_response =
      requires(const SmallStrain<R>& at, R a) { Elasticity::small_response(at, a, a); };

  // Where a small strain is proven to lie between the critical ones. Where all three eigenvalues nearly meet at a bound, the
  // invariants tell by rounding alone, so the bounds are drawn in by more than that.
  template <class R>
  NEVE_INLINE static auto is_elastic(const SmallStrain<R>& at, const Parameters<R>& q) {
    using T = scalar_t<R>;
    constexpr T sure = T(1) - (std::is_same_v<T, float> ? T(0.01) : T(2e-5)), far = T(small_strain);
    const R least = q.theta_c * (q.theta_c - T(2)), most = q.theta_s * (q.theta_s + T(2));  // s^2 - 1
    return at.lies_between(max(least, splat<R>(-far)) * sure, min(most, splat<R>(far)) * sure);
  }

  template <class R>
  NEVE_INLINE static Mapped<R> small_elastic(const Mat3<R>& F, const SmallStrain<R>& at, const R& J_P,
                                             const Parameters<R>& q) {
    const R kept = min(q.J_P_max, J_P), h = hardening(kept, q);
    return {F, kept, Elasticity::small_response(at, R(q.mu0 * h), R(q.lam0 * h))};
  }

  template <class S, class R>
  NEVE_INLINE static Mapped<R> map_stretches(const S& trial, const R& J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const Vec3<R>& e = trial.strain;
    Vec3<R> kept{clamp(e.x, R(-q.theta_c), q.theta_s), clamp(e.y, R(-q.theta_c), q.theta_s),
                 clamp(e.z, R(-q.theta_c), q.theta_s)};
    Response<R> response = flow(e, kept, q);
    Mapped<R> out{trial.F, J_P, {}};
    const Vec3<R> excess = e - kept;
    if (any((excess.x != T(0)) | (excess.y != T(0)) | (excess.z != T(0)))) {
      out.F_E = trial.without(excess);
      R before = splat<R>(1), after = splat<R>(1);
      for (int k = 0; k < 3; ++k) {
        const R stretch = T(1) + kept[k];
        before = before * select(excess[k] != T(0), trial.sigma[k], stretch);
        after = after * stretch;
      }
      out.J_P = out.J_P * (before / after);
    }
    out.J_P = min(q.J_P_max, out.J_P);  // in this order a NaN stays one
    out.stress = trial.stress(hardened(response, hardening(out.J_P, q)));
    return out;
  }

  // Of the elasticity, hardened as it is.
  template <class R>
  static Tangent<R> tangent(const Vec3<R>& e, R J_P, const Parameters<R>& q) {
    const R h = hardening(J_P, q);
    return Elasticity::tangent(e, R(q.mu0 * h), R(q.lam0 * h));
  }

  template <class R>
  static R energy(const Mat3<R>& F_E, R J_P, const Parameters<R>& q) {
    return with_stretches(F_E, [&](const auto& at) NEVE_INLINE_LAMBDA {
      return R(hardening(J_P, q) * Elasticity::energy(at.strain, q.mu0, q.lam0));
    });
  }
};

}  // namespace neve
