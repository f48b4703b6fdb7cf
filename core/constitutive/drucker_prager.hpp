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
//
// Cohesion is not lost by tearing: what is pulled apart against p_t stays stored, p_t ln J_P, and coming back returns it.
#pragma once

#include "constitutive/hencky.hpp"

namespace neve {

struct DruckerPrager : HenckyFlow {
  static constexpr Word word{"drucker_prager", "loose grains with friction and a little cohesion",
                             "Klar et al. 2016 (as quoted in public codes)", "klar2016"};

  static constexpr bool compacts = false;

  struct Constants : ElasticConstants {
    double friction_angle, cohesion, J_P_max;  // [degrees], [Pa], [1]
    double sine;                               // of friction_angle: laws make their parameters for every pack
  };
  static void complete(Constants& c) { c.sine = std::sin(c.friction_angle * (3.14159265358979323846 / 180)); }

  static constexpr const char* paper = "Klar et al. 2016 for the law; value: our choice";
  static constexpr Constant<Constants> constants[] = {
      rho0_of<Constants>(400, paper),
      E0_of<Constants>(3.5e5, paper),
      nu_of<Constants>(0.3, paper),
      {"friction_angle",
       &Constants::friction_angle,
       35,
       "degrees",
       {1, 80},
       {1.0, 80.0},
       Role::plastic,
       paper,
       "Angle of internal friction."},
      {"cohesion",
       &Constants::cohesion,
       0,
       "Pa",
       {0, 1e9},
       {1.0, 1e9},
       Role::threshold,
       paper,
       "Shear strength at no pressure; cohesion / tan(friction_angle) is at most a tenth of the bulk "
       "modulus."},
      J_P_max_of<Constants>(20, "snow torn apart further bears load again before all that room is closed."),
  };

  // Its tension at no shear, p_t, is at most a tenth of the bulk modulus.
  static double most_strength(const Constants& c) {
    const double tension = c.cohesion / std::tan(c.friction_angle * (3.14159265358979323846 / 180));
    return tension > 0 ? most_yield * c.E0 / (3 * (1 - 2 * c.nu)) / tension
                       : std::numeric_limits<double>::infinity();
  }

  static double hardening_exponent(const Constants&) { return 0; }

  template <class R>
  struct Parameters {
    R mu, lam, apex, cone, J_P_max;  // apex e_c; cone: ||dev eps|| <= cone (e_c - e)
  };

  template <class R>
  static Parameters<R> parameters(const Snow& snow, R stiffness, R strength) {
    using T = scalar_t<R>;
    const auto given = snow.constants<Constants>();
    const Lame& c = snow.lame;
    const double sine = given.sine, tangent = sine / std::sqrt(1 - sine * sine);
    const double M_phi = 6 * sine / (3 - sine);
    return {stiffness * T(c.mu), stiffness * T(c.lam),
            strength * T(given.cohesion / (tangent * c.K)) / stiffness,
            splat<R>(T(M_phi * c.K / (std::sqrt(6.0) * c.mu))), splat<R>(T(given.J_P_max))};
  }

  template <class R>
  static Mapped<R> return_map(const Mat3<R>& F_trial, R J_P, const Parameters<R>& q) {
    return with_stretches(F_trial,
                          [&](const auto& at) NEVE_INLINE_LAMBDA { return map_stretches(at, J_P, q); });
  }

  template <class S, class R>
  NEVE_INLINE static Mapped<R> map_stretches(const S& at, const R& J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const Vec3<R> trial = HenckyElasticity::log_strain(at.strain);
    const auto split = SplitStrain<R>::of(trial);
    const R apart = log1p(max(R(J_P - T(1)), splat<R>(T(least_stretch - 1))));
    const R e = split.volume + apart;
    const auto torn = e >= q.apex;
    const R limit = q.cone * max(q.apex - e, splat<R>(0));
    const auto slides = split.shear > limit;
    const auto flows = torn | slides | (apart != T(0));
    Mapped<R> out{at.F, J_P, {}};
    Vec3<R> eps = trial;
    if (any(flows)) {
      const R factor = select(slides, R(limit / split.shear), splat<R>(1));
      eps = select(flows, split.with(min(e, q.apex), factor), trial);
      out.F_E = with_strain(at, eps, flows);
      out.J_P = min(q.J_P_max, exp(max(R(e - q.apex), splat<R>(0))));
    }
    out.stress = at.stress(HenckyElasticity::respond_to_log(eps, q.mu, q.lam));
    return out;
  }

  // Snow that is torn apart bears p_t, however far: nothing resists until its grains touch again. 1 or 0.
  template <class R>
  static R resistance(const R& J_P) {
    const R one = splat<R>(1);
    return select(J_P > one, splat<R>(0), one);
  }
  template <class R>
  static Tangent<R> tangent(const Vec3<R>& e, R J_P, const Parameters<R>& q) {
    return times(HenckyFlow::tangent(e, J_P, q), resistance(J_P));
  }

  // Psi of F_E, and what tearing has stored: p_t ln J_P.
  template <class R>
  NEVE_INLINE static R energy(const Mat3<R>& F_E, R J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const R tension = (q.lam + q.mu * T(2.0 / 3)) * q.apex, apart = log1p(max(R(J_P - T(1)), splat<R>(0)));
    return HenckyFlow::energy(F_E, J_P, q) + tension * apart;
  }
};

}  // namespace neve
