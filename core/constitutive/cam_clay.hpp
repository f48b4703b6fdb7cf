// Cohesive snow that crushes and fractures: Hencky elasticity and the cohesive Cam-Clay of Gaume et al. 2018, with
// the associative flow that they and Li et al. 2021 use.
//
//   y = (1 + 2 beta) q^2 + M^2 (p + beta p0) (p - p0) <= 0        p = -K tr eps, q = sqrt 6 mu ||dev eps||
//   p0 = K sinh(xi max(-alpha, 0)),  alpha = alpha0 + ln J_P,  alpha0 = -asinh(p0_start / K) / xi
//
// Associative flow is the projection onto the ellipse that is closest in the energy norm, (p - p_trial)^2 / (2 K) +
// (q - q_trial)^2 / (6 mu): with p0 frozen at the J_P of the step's start it never makes energy. Compaction (J_P
// falls) hardens, expansion softens, down to a p0 of 1e-6 K. J_P is bounded inside the hardening as in
// snow_plasticity.hpp. (A return at constant p, as some programs have it, shows no softening in shear.)
//
// Projection. In units of the half-axes a = (1 + beta) p0 / 2 and b = M a / sqrt(1 + 2 beta) the ellipse is the
// circle P^2 + Q^2 = 1, and the closest point is x = P / (1 + t), y = Q / (1 + t / k), k = b^2 K / (3 mu a^2), where
// t >= 0 solves S(t) = x^2 + y^2 = 1. 1/sqrt(S) is concave and nearly linear, so Newton on 1/sqrt(S) - 1 climbs to
// the root from below, and t = max(|P| - 1, k (Q - 1)), where S <= 2, is below. p0 enters as p0 / K alone, so every
// number here is a strain.
#pragma once

#include "constitutive/hencky.hpp"

namespace neve {

struct CamClay : HenckyFlow {
  static constexpr Word word{"cam_clay", "snow that compacts, with cohesion",
                             "Gaume et al. 2018 and Li et al. 2021 (as quoted in public codes)",
                             "gaume2018 li2020"};

  struct Constants : ElasticConstants {
    double xi, M, beta, p0, J_P_min, J_P_max;
  };
  static constexpr const char* paper = "Li et al. 2021, case I (as quoted in a public code)";
  static constexpr Constant<Constants> constants[] = {
      rho0_of<Constants>(250, paper),
      E0_of<Constants>(3e6, paper),
      nu_of<Constants>(0.3, paper),
      {"xi",
       &Constants::xi,
       1,
       "1",
       {1e-4, 100},  // the plastic strain at the start is asinh(p0 / K) / xi
       {1e-3, 100.0},
       Role::plastic,
       paper,
       "Hardening; larger is more brittle."},
      {"M",
       &Constants::M,
       0.5,
       "1",
       {0, 3, true},
       {0.1, 3.0},
       Role::plastic,
       paper,
       "Slope of the critical state line: shear stress over pressure."},
      {"beta",
       &Constants::beta,
       0,
       "1",
       {0, 1},
       {0.0, 1.0},
       Role::plastic,
       paper,
       "Cohesion: strength in tension over strength in compression."},
      {"p0",
       &Constants::p0,
       3e3,
       "Pa",
       {0, 1e9, true},
       {1.0, 1e9},
       Role::threshold,
       paper,
       "Pressure that crushes at the start, at most a tenth of the bulk modulus."},
      J_P_min_of<Constants>(0.6),
      J_P_max_of<Constants>(20),
  };

  static double most_strength(const Constants& c) { return most_yield * c.E0 / (3 * (1 - 2 * c.nu)) / c.p0; }

  static double hardening_exponent(const Constants& c) { return -c.xi * std::log(c.J_P_min); }

  template <class R>
  struct Parameters {
    R mu, lam, start, xi, beta, aspect, k, J_P_min, J_P_max;
    // start: asinh(p0 / K); aspect: (b / (sqrt 6 mu)) / (a / K), the ellipse's shape in strains
  };

  template <class R>
  static Parameters<R> parameters(const Snow& snow, R stiffness, R strength) {
    using T = scalar_t<R>;
    const auto given = snow.constants<Constants>();
    const Lame c = lame(given);
    const double slope2 = given.M * given.M / (1 + 2 * given.beta);
    return {stiffness * T(c.mu),
            stiffness * T(c.lam),
            asinh_positive(R(strength * T(given.p0 / c.K) / stiffness)),
            splat<R>(T(given.xi)),
            splat<R>(T(given.beta)),
            splat<R>(T(std::sqrt(slope2 / 6) * c.K / c.mu)),
            splat<R>(T(slope2 * c.K / (3 * c.mu))),
            splat<R>(T(given.J_P_min)),
            splat<R>(T(given.J_P_max))};
  }

  // p0 / K. The upper bound, sinh(80), is where the numbers of float32 end.
  template <class R>
  static R size(R J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const R w = q.start - q.xi * log1p(R(clamp(J_P, q.J_P_min, q.J_P_max) - T(1)));
    return max(sinh_positive(clamp(w, splat<R>(0), splat<R>(80))), splat<R>(T(1e-6)));
  }

  // t of the closest point, per lane: a lane that has arrived stays where it is.
  template <class R>
  static R closest(R P, R Q, R k) {
    using T = scalar_t<R>;
    constexpr T enough = T(1) + 4 * std::numeric_limits<T>::epsilon();
    R t = max(max(abs(P) - T(1), k * (Q - T(1))), splat<R>(0));
    for (int i = 0; i < 16; ++i) {
      const R u = T(1) + t, w = k + t;
      const R x = P / u, y = Q * k / w;
      const R S = x * x + y * y;
      const auto going = S > enough;
      if (!any(going)) break;
      const R next = t + S * (sqrt(S) - T(1)) / (x * x / u + y * y / w);
      t = select(going, next, t);
    }
    return t;
  }

  template <class R>
  static Mapped<R> return_map(const Mat3<R>& F_trial, R J_P, const Parameters<R>& q) {
    using T = scalar_t<R>;
    const Svd3<R> svd = svd3<false>(F_trial);
    const Vec3<R> trial = HenckyElasticity::log_strain(svd.strain);
    const auto split = SplitStrain<R>::of(trial);
    const R half = T(0.5) * size(J_P, q);
    const R a = half * (T(1) + q.beta), centre = half * (T(1) - q.beta);
    const R P = (-split.volume - centre) / a, Q = split.shear / (a * q.aspect);
    const auto flows = P * P + Q * Q > T(1);
    Mapped<R> out{F_trial, min(q.J_P_max, J_P), {}};
    Vec3<R> eps = trial;
    if (any(flows)) {
      const R t = closest(P, Q, q.k);
      const R x = P / (T(1) + t), shrink = q.k / (q.k + t), y = Q * shrink;
      const R onto = T(1) / sqrt(max(R(x * x + y * y), splat<R>(T(0.25))));  // what rounding left
      const R volume = -(centre + a * (x * onto));
      eps = select(flows, split.with(volume, R(shrink * onto)), trial);
      out.F_E = with_strain(F_trial, svd, eps, flows);
      out.J_P = min(q.J_P_max, R(J_P * select(flows, exp(R(split.volume - volume)), splat<R>(1))));
    }
    out.stress = in_frame(svd.U, HenckyElasticity::respond_to_log(eps, q.mu, q.lam));
    return out;
  }
};

}  // namespace neve
