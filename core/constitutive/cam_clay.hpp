// Cohesive snow that crushes and fractures: Hencky elasticity and the cohesive Cam-Clay of Gaume et al. 2018, with
// the associative flow that they and Li et al. 2021 use.
//
//   y = (1 + 2 beta) q^2 + M^2 (p + beta p0) (p - p0) <= 0        p = -K tr eps, q = sqrt 6 mu ||dev eps||
//   p0 = K sinh(xi max(-alpha, 0)),  alpha = alpha0 + ln J_P,  alpha0 = -asinh(p0_start / K) / xi
//
// Associative flow, integrated implicitly: the end of a step is the projection onto the ellipse of the p0 that it has
// there, closest in the energy norm, (p - p_trial)^2 / (2 K) + (q - q_trial)^2 / (6 mu). An ellipse holds p = q = 0, so
// that whatever p0 is found, no energy is made. Compaction (J_P falls) hardens, expansion softens, down to a p0 of
// 1e-6 K. J_P is bounded inside the hardening as in snow_plasticity.hpp. (A return at constant p, as some programs
// have it, shows no softening in shear.) p0 hardens to 10 K at most: a pressure of that size is a strain that no snow
// reaches, but what rounding leaves of it, eps p0, would bear tension that the tip of the ellipse forbids.
//
// Projection. In units of the half-axes a = (1 + beta) p0 / 2 and b = M a / sqrt(1 + 2 beta) the ellipse is the
// circle P^2 + Q^2 = 1, and the closest point is x = P / (1 + t), y = Q / (1 + t / k), k = b^2 K / (3 mu a^2), where
// t >= 0 solves S(t) = x^2 + y^2 = 1. 1/sqrt(S) is concave and nearly linear, so Newton on 1/sqrt(S) - 1 climbs to
// the root from below, and t = max(|P| - 1, k (Q - 1)), where S <= 2, is below. p0 enters as p0 / K = sinh w alone, so
// every number here is a strain.
//
// Hardening. What flows compacts by D(w) = ln J_E - ln J_trial, and w = w_start + xi D(w) is one equation for one
// unknown. Its right side is bounded, hence a root lies between the bounds; Newton finds it from w_start with
// dD/dw = -cosh w (c t + x (A + x c / u) / N) / u, u = 1 + t, N = x^2 / u + y^2 / (k + t), A = a / p0, c = (1 - beta) / 2.
// Where snow softens faster than it is unloaded, the slope is of the other sign: it goes to the lower bound, or is
// bisected.
#pragma once

#include "constitutive/hencky.hpp"

namespace neve {

struct CamClay : HenckyFlow {
  static constexpr Word word{"cam_clay", "snow that compacts, with cohesion",
                             "Gaume et al. 2018 and Li et al. 2021 (as quoted in public codes)",
                             "gaume2018 li2020"};

  static constexpr bool compacts = true;

  struct Constants : ElasticConstants {
    double xi, M, beta, p0, J_P_min, J_P_max;
    double ln_J_P_min, ln_J_P_max;  // laws make their parameters for every pack
  };
  static void complete(Constants& c) {
    c.ln_J_P_min = std::log(c.J_P_min);
    c.ln_J_P_max = std::log(c.J_P_max);
  }

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
    R mu, lam, start, xi, beta, aspect, k, J_P_max, ln_J_P_min, ln_J_P_max;
    // start: asinh(p0 / K); aspect: (b / (sqrt 6 mu)) / (a / K), the ellipse's shape in strains
  };

  template <class R>
  static Parameters<R> parameters(const Snow& snow, R stiffness, R strength) {
    using T = scalar_t<R>;
    const auto given = snow.constants<Constants>();
    const Lame& c = snow.lame;
    const double slope2 = given.M * given.M / (1 + 2 * given.beta);
    return {stiffness * T(c.mu),
            stiffness * T(c.lam),
            asinh_positive(R(strength * T(given.p0 / c.K) / stiffness)),
            splat<R>(T(given.xi)),
            splat<R>(T(given.beta)),
            splat<R>(T(std::sqrt(slope2 / 6) * c.K / c.mu)),
            splat<R>(T(slope2 * c.K / (3 * c.mu))),
            splat<R>(T(given.J_P_max)),
            splat<R>(T(given.ln_J_P_min)),
            splat<R>(T(given.ln_J_P_max))};
  }

  // The bounds of w, from p0 = 1e-6 K to 10 K.
  template <class R>
  struct Hardening {
    R start, least, most;  // w before the step, as if without bounds

    static Hardening of(R J_P, const Parameters<R>& q) {
      using T = scalar_t<R>;
      const R low = splat<R>(T(1e-6)), high = splat<R>(T(2.998222950297970));
      const R past = log1p(max(R(J_P - T(1)), splat<R>(T(least_stretch - 1))));
      return {q.start - q.xi * past, clamp(R(q.start - q.xi * q.ln_J_P_max), low, high),
              clamp(R(q.start - q.xi * q.ln_J_P_min), low, high)};
    }
    R bounded(R w) const { return clamp(w, least, most); }
  };

  // t of the closest point, per lane: a lane that has arrived stays where it is. `guess` may lie anywhere: a step of
  // Newton's ends below the root, as the function is concave.
  template <class R>
  static R closest(R P, R Q, R k, R guess) {
    using T = scalar_t<R>;
    constexpr T enough = T(1) + 4 * std::numeric_limits<T>::epsilon();
    const R least = max(max(abs(P) - T(1), k * (Q - T(1))), splat<R>(0));
    R t = max(guess, least);
    for (int i = 0; i < 16; ++i) {
      const R u = T(1) + t, w = k + t;
      const R x = P / u, y = Q * k / w;
      const R S = x * x + y * y;
      const auto going = S > enough;
      if (i > 0 && !any(going)) break;
      const R next = t + S * (sqrt(S) - T(1)) / (x * x / u + y * y / w);
      t = i > 0 ? select(going, next, t) : max(next, least);
    }
    return t;
  }

  // A trial state against the ellipse of p0 / K = sinh w: its pressure over K and the size of its deviator [1].
  template <class R>
  struct Projection {
    R P, Q, t;         // the trial, in half-axes; and the multiplier of its closest point
    R volume, shrink;  // of the closest point: ln J_E, and the factor on the deviator
    R slope;           // d volume / dw

    static Projection trial(R pressure, R shear, R size, const Parameters<R>& q) {
      using T = scalar_t<R>;
      const R half = T(0.5) * size, a = half * (T(1) + q.beta);
      return {
          (pressure - half * (T(1) - q.beta)) / a, shear / (a * q.aspect), R{}, -pressure, splat<R>(1), R{}};
    }
    auto outside() const { return P * P + Q * Q > scalar_t<R>(1); }

    static Projection onto(R pressure, R shear, R size, R guess, const Parameters<R>& q) {
      using T = scalar_t<R>;
      const R A = T(0.5) * (T(1) + q.beta), c = T(0.5) * (T(1) - q.beta);
      Projection out = trial(pressure, shear, size, q);
      const auto flows = out.outside();
      const R t = out.t = closest(out.P, out.Q, q.k, guess), u = T(1) + t, v = q.k + t;
      const R x = out.P / u, y = out.Q * q.k / v;
      const R norm = T(1) / sqrt(max(R(x * x + y * y), splat<R>(T(0.25))));  // what rounding left
      const R volume = -(c * size + A * size * (x * norm));
      const R N = max(R(x * x / u + y * y / v), splat<R>(std::numeric_limits<T>::min()));
      const R slope = -sqrt(R(T(1) + size * size)) * (c * t + x * (A + x * c / u) / N) / u;
      out.volume = select(flows, volume, out.volume);
      out.shrink = select(flows, R(norm * q.k / v), out.shrink);
      out.slope = select(flows, slope, out.slope);
      return out;
    }
  };

  // sinh(w + step) from size = sinh w: by series where the step is short.
  template <class R>
  static R moved_sinh(R w, R size, R step) {
    using T = scalar_t<R>;
    const R z = step * step;
    const R cosh_1 = z * (T(0.5) + z * (T(1.0 / 24) + z * T(1.0 / 720)));
    const R sinh = step * (T(1) + z * (T(1.0 / 6) + z * (T(1.0 / 120) + z * T(1.0 / 5040))));
    const R moved = size + (size * cosh_1 + sqrt(R(T(1) + size * size)) * sinh);
    const auto far = abs(step) > T(1.0 / 32);
    return any(far) ? select(far, sinh_positive(R(w + step)), moved) : moved;
  }

  // The projection whose p0 is that of its own J_P, in the lanes that flow: each is iterated by itself.
  template <class R, class M>
  static Projection<R> hardened(const SplitStrain<R>& trial, const Hardening<R>& h, R size,
                                const Parameters<R>& q, M going) {
    using T = scalar_t<R>;
    constexpr T few = 4 * std::numeric_limits<T>::epsilon();
    constexpr int newton = 12, most = newton + std::numeric_limits<T>::digits;
    R w = h.bounded(h.start), low = h.least, high = h.most;
    auto out = Projection<R>::onto(-trial.volume, trial.shear, size, R{}, q);
    auto low_is_known = low != low;  // nowhere
    for (int i = 0; i < most; ++i) {
      const R rest = h.bounded(R(h.start + q.xi * (out.volume - trial.volume))) - w;
      const R noise = few * (w + abs(h.start) + q.xi * (abs(out.volume) + abs(trial.volume)));
      going = going & (abs(rest) > noise);
      if (!any(going)) break;
      const auto grows = rest > T(0);
      low_is_known = low_is_known | grows | (w <= low);
      low = select(grows, w, low);
      high = select(grows, high, w);
      const R slope = q.xi * out.slope - T(1), next = i < newton ? R(w - rest / slope) : low;
      const auto good = (slope < T(-0.1)) & (next > low) & (next < high);
      const R halved = select(low_is_known, R(T(0.5) * (low + high)), low);
      const R step = select(going, select(good, next, halved) - w, R{});
      size = moved_sinh(w, size, step);
      w = w + step;
      const auto now = Projection<R>::onto(-trial.volume, trial.shear, size, out.t, q);
      out.t = select(going, now.t, out.t);
      out.volume = select(going, now.volume, out.volume);
      out.shrink = select(going, now.shrink, out.shrink);
      out.slope = select(going, now.slope, out.slope);
    }
    return out;
  }

  template <class R>
  static Mapped<R> return_map(const Mat3<R>& F_trial, R J_P, const Parameters<R>& q) {
    return with_stretches(F_trial,
                          [&](const auto& at) NEVE_INLINE_LAMBDA { return map_stretches(at, J_P, q); });
  }

  template <class S, class R>
  NEVE_INLINE static Mapped<R> map_stretches(const S& at, const R& J_P, const Parameters<R>& q) {
    const Vec3<R> trial = HenckyElasticity::log_strain(at.strain);
    const auto split = SplitStrain<R>::of(trial);
    const auto h = Hardening<R>::of(J_P, q);
    const R size = sinh_positive(h.bounded(h.start));
    const auto flows = Projection<R>::trial(-split.volume, split.shear, size, q).outside();
    Mapped<R> out{at.F, min(q.J_P_max, J_P), {}};
    Vec3<R> eps = trial;
    if (any(flows)) {
      const auto end = hardened(split, h, size, q, flows);
      eps = select(flows, split.with(end.volume, end.shrink), trial);
      out.F_E = with_strain(at, eps, flows);
      const R grown = select(flows, exp(R(split.volume - end.volume)), splat<R>(1));
      out.J_P = min(q.J_P_max, R(J_P * grown));
    }
    out.stress = at.stress(HenckyElasticity::respond_to_log(eps, q.mu, q.lam));
    return out;
  }
};

}  // namespace neve
