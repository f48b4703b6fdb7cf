// Hencky's elasticity: linear in the logarithms of the principal stretches.
//
//   Psi = mu sum eps_k^2 + lam/2 (sum eps_k)^2,     tau_k = 2 mu eps_k + lam sum eps_k,     eps = ln sigma
//
// The sum of eps is ln J exactly, so the pressure is -K ln J and a plastic flow splits J without error: the
// elasticity of choice for laws in p and q. Moduli along the axes: 2 mu + lam - tau_k (P), mu x / (1 - exp(-x)) with
// x = 2 (eps_k - eps_l) (shear), which grows with x.
#pragma once

#include "constitutive/snow_plasticity.hpp"

namespace neve {

struct HenckyElasticity {
  template <class R>
  static Vec3<R> log_strain(const Vec3<R>& e) {
    const R least = splat<R>(scalar_t<R>(least_stretch - 1));
    return {log1p(max(e.x, least)), log1p(max(e.y, least)), log1p(max(e.z, least))};
  }

  // The response to logarithmic strains.
  template <class R>
  NEVE_INLINE static Response<R> respond_to_log(const Vec3<R>& eps, R mu, R lam) {
    using T = scalar_t<R>;
    const R pressure = lam * (eps.x + eps.y + eps.z), two_mu = T(2) * mu;
    const R low = smallest(eps), x = T(2) * (largest(eps) - low);
    const R shear = select(x > T(0), R(x / -expm1(R(-x))), splat<R>(1));
    return {pressure,
            {two_mu * eps.x, two_mu * eps.y, two_mu * eps.z},
            max(two_mu + lam - pressure - two_mu * low, R(mu * shear))};
  }
  template <class R>
  NEVE_INLINE static R energy_of_log(const Vec3<R>& eps, R mu, R lam) {
    const R trace = eps.x + eps.y + eps.z;
    return mu * dot(eps, eps) + scalar_t<R>(0.5) * lam * trace * trace;
  }

  template <class R>
  NEVE_INLINE static Response<R> respond(const Vec3<R>& e, R mu, R lam) {
    return respond_to_log(log_strain(e), mu, lam);
  }
  template <class R>
  NEVE_INLINE static R energy(const Vec3<R>& e, R mu, R lam) {
    return energy_of_log(log_strain(e), mu, lam);
  }

  // Psi_ij = ((2 mu - tau_i) delta_ij + lam) / (s_i s_j); with l = ln(s_i / s_j) / (s_i - s_j),
  //   m = (mu l (s_i + s_j) - (tau_i + tau_j) / 2) / (s_i s_j),   p = (tau_i s_j + tau_j s_i) / (s_i s_j (s_i + s_j))
  template <class R>
  static Tangent<R> tangent(const Vec3<R>& strain, R mu, R lam) {
    using T = scalar_t<R>;
    const R least = splat<R>(T(least_stretch - 1)), one = splat<R>(1), zero = splat<R>(0), two_mu = T(2) * mu;
    const Vec3<R> e{max(strain.x, least), max(strain.y, least), max(strain.z, least)}, eps = log_strain(e);
    const R pressure = lam * (eps.x + eps.y + eps.z);
    const Vec3<R> s{one + e.x, one + e.y, one + e.z}, r{one / s.x, one / s.y, one / s.z};
    const Vec3<R> tau{two_mu * eps.x + pressure, two_mu * eps.y + pressure, two_mu * eps.z + pressure};
    const auto own = [&](int i) { return (two_mu + lam - tau[i]) * r[i] * r[i]; };
    Tangent<R> t{{own(0), own(1), own(2), lam * r.x * r.y, lam * r.x * r.z, lam * r.y * r.z}, {}, {}};
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const R pair = r[i] * r[j], x = (e[i] - e[j]) * r[j];
      const R slope = r[j] * select(x != zero, R(log1p(x) / select(x != zero, x, one)), one);
      t.m[k] = (mu * slope * (s[i] + s[j]) - T(0.5) * (tau[i] + tau[j])) * pair;
      t.p[k] = (tau[i] * s[j] + tau[j] * s[i]) * pair / (s[i] + s[j]);
    }
    return t;
  }
};

struct Hencky : SnowPlasticity<HenckyElasticity> {
  static constexpr Word word{"hencky", "elasticity in logarithmic strains under the same plasticity",
                             "Klar et al. 2016 (as quoted in public codes)", "klar2016"};
};

// Volumetric and deviatoric part of a logarithmic strain: eps = volume / 3 + deviator.
template <class R>
struct SplitStrain {
  R volume;  // ln J_E
  Vec3<R> deviator;
  R shear;  // |deviator|

  static SplitStrain of(const Vec3<R>& eps) {
    using T = scalar_t<R>;
    const R volume = eps.x + eps.y + eps.z, third = volume * T(1.0 / 3);
    const Vec3<R> deviator{eps.x - third, eps.y - third, eps.z - third};
    return {volume, deviator, sqrt(dot(deviator, deviator))};
  }
  // The strain of another volume, with the deviator times `factor`.
  Vec3<R> with(R other_volume, R factor) const {
    const R third = other_volume * scalar_t<R>(1.0 / 3);
    return {third + deviator.x * factor, third + deviator.y * factor, third + deviator.z * factor};
  }
};

// What laws of Hencky elasticity share whose flow is their own; their parameters have mu and lam.
struct HenckyFlow {
  static constexpr bool has_elastic_option = false;
  static constexpr const char* plasticity_cites = "";
  static constexpr const char* limit = "so that elastic strains stay moderate";

  // These laws end on the yield surface of the step's start: compression makes no energy.
  template <class C>
  static double max_compression(const C&, double) {
    return std::numeric_limits<double>::infinity();
  }

  template <class R, class P>
  static Stress<R> stress(const Mat3<R>& F_E, R, const P& q) {
    return with_stretches(F_E, [&](const auto& at) NEVE_INLINE_LAMBDA {
      return at.stress(HenckyElasticity::respond(at.strain, q.mu, q.lam));
    });
  }

  template <class R, class P>
  NEVE_INLINE static R energy(const Mat3<R>& F_E, R, const P& q) {
    return with_stretches(F_E, [&](const auto& at) NEVE_INLINE_LAMBDA {
      return HenckyElasticity::energy(at.strain, q.mu, q.lam);
    });
  }

  // Of the elasticity, as long as the snow does not flow.
  template <class R, class P>
  static Tangent<R> tangent(const Vec3<R>& e, R, const P& q) {
    return HenckyElasticity::tangent(e, q.mu, q.lam);
  }

 protected:
  // F_E with the logarithmic strains eps in the lanes that flow.
  template <class S, class R, class M>
  static Mat3<R> with_strain(const S& trial, const Vec3<R>& eps, M flows) {
    Vec3<R> excess;
    for (int k = 0; k < 3; ++k) excess[k] = select(flows, R(trial.strain[k] - expm1(eps[k])), splat<R>(0));
    return trial.without(excess);
  }
};

}  // namespace neve
