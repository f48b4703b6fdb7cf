// Loose snow: Hencky elasticity inside the cone of Drucker and Prager, after Klar et al. 2016, with cohesion.
//
//   q <= M_phi (p + p_t),   M_phi = 6 sin phi / (3 - sin phi),   p_t = cohesion / tan phi
//   p = -K tr eps,   q = sqrt(3/2) ||dev tau|| = sqrt 6 mu ||dev eps||
//
// Deviators shrink onto the cone at constant volume. Past the apex, tr eps = e_c = p_t / K, snow comes apart at
// constant tension p_t, and J_P remembers by how much: the true log-volume is e = ln J_E + ln J_P. It stays in J_P
// until e is back at e_c; only then grains touch and all of e is elastic again. That is the volume correction, exact
// in J up to J_P_max: without it snow that was torn apart and pushed together again would be larger than before. Snow
// torn apart beyond J_P_max forgets the rest, and touches again while it is larger by that. Short of the cap J_E J_P
// is conserved to rounding, and a hydrostatic compression is elastic.
#pragma once

#include "constitutive/hencky.hpp"

namespace neve {

struct DruckerPrager : HenckyFlow {
  template <class R>
  struct Parameters {
    R mu, lam, apex, cone, J_P_max;  // apex e_c; cone: ||dev eps|| <= cone (e_c - e)
  };

  template <class R>
  static Parameters<R> parameters(const Snow& snow, R stiffness, R strength) {
    using T = scalar_t<R>;
    const Lame c = lame(snow);
    const double sine = snow.sine, tangent = sine / std::sqrt(1 - sine * sine);
    const double M_phi = 6 * sine / (3 - sine);
    return {stiffness * T(c.mu), stiffness * T(c.lam),
            strength * T(snow.cohesion / (tangent * c.K)) / stiffness,
            splat<R>(T(M_phi * c.K / (std::sqrt(6.0) * c.mu))), splat<R>(T(snow.J_P_max))};
  }

  template <class R>
  static Mapped<R> return_map(const Mat3<R>& F_trial, R J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const Svd3<R> svd = svd3<false>(F_trial);
    const Vec3<R> trial = HenckyElasticity::log_strain(svd.strain);
    const auto split = SplitStrain<R>::of(trial);
    const R apart = log1p(max(R(J_P - T(1)), splat<R>(T(least_stretch - 1))));
    const R e = split.volume + apart;
    const auto torn = e >= q.apex;
    const R limit = q.cone * max(q.apex - e, splat<R>(0));
    const auto slides = split.shear > limit;
    const auto flows = torn | slides | (apart != T(0));
    Mapped<R> out{F_trial, J_P, {}};
    Vec3<R> eps = trial;
    if (any(flows)) {
      const R factor = select(slides, R(limit / split.shear), splat<R>(1));
      eps = select(flows, split.with(min(e, q.apex), factor), trial);
      out.F_E = with_strain(F_trial, svd, eps, flows);
      out.J_P = min(q.J_P_max, exp(max(R(e - q.apex), splat<R>(0))));
    }
    out.stress = in_frame(svd.U, HenckyElasticity::respond_to_log(eps, q.mu, q.lam));
    return out;
  }
};

}  // namespace neve
