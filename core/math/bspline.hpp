// B-spline shape functions in units of cells: weights and their derivatives (Steffen et al. 2008; docs/theory.md).
#pragma once

#include "math/list.hpp"
#include "math/real.hpp"

namespace neve {

// s = x / dx - shift splits into the first node `base = floor(s)` and the fraction f = s - base in [0, 1).
struct Quadratic {
  static constexpr Word word{"quadratic", "27 nodes a particle", "our choice", "steffen2008"};
  static constexpr int nodes = 3;
  static constexpr double shift = 0.5;
  static constexpr double inverse_inertia = 4;  // D^-1 dx^2: D = dx^2 / 4
  static constexpr double sharpness = 6;        // the largest sum w'^2 / w of an axis, at f = 0 and 1
  // A block owns particles with s - 4 block in [margin, margin + 4) when sorted and keeps them in [0, reach).
  static constexpr double margin = 1;
  static constexpr double reach = 6 - 1e-3;  // short of the end, where rounding could pass it

  template <class R>
  NEVE_INLINE static void weights(R f, R* w, R* dw) {
    using T = scalar_t<R>;
    const R a = T(1) - f, b = f - T(0.5);
    w[0] = T(0.5) * a * a;
    w[1] = T(0.75) - b * b;
    w[2] = T(0.5) * f * f;
    dw[0] = -a;
    dw[1] = T(-2) * b;
    dw[2] = f;
  }
  // x_i - x_p in cells, of the k-th node.
  template <class R>
  NEVE_INLINE static R offset(R f, int k) {
    return scalar_t<R>(k - 0.5) - f;
  }
};

struct Cubic {
  static constexpr Word word{"cubic", "64 nodes a particle",
                             "Stomakhin et al. 2013 (as quoted in public codes)", "steffen2008"};
  static constexpr int nodes = 4;
  static constexpr double shift = 1;
  static constexpr double inverse_inertia = 3;  // D = dx^2 / 3
  static constexpr double sharpness = 3.137;    // at f = 0.276 and 0.724
  static constexpr double margin = 0.5;
  static constexpr double reach = 5 - 1e-3;

  template <class R>
  NEVE_INLINE static void weights(R f, R* w, R* dw) {
    using T = scalar_t<R>;
    const R a = T(1) - f;
    const T sixth = T(1) / T(6), two_thirds = T(2) / T(3);
    w[0] = sixth * a * a * a;
    w[1] = (T(0.5) * f - T(1)) * f * f + two_thirds;
    w[2] = (T(0.5) * a - T(1)) * a * a + two_thirds;
    w[3] = sixth * f * f * f;
    dw[0] = T(-0.5) * a * a;
    dw[1] = (T(1.5) * f - T(2)) * f;
    dw[2] = (T(2) - T(1.5) * a) * a;
    dw[3] = T(0.5) * f * f;
  }
  template <class R>
  NEVE_INLINE static R offset(R f, int k) {
    return scalar_t<R>(k - 1) - f;
  }
};

using Splines = List<Quadratic, Cubic>;

// f(Spline{}) for the spline at that place of the list.
template <class F>
NEVE_INLINE auto with_spline(int spline, F&& f) {
  return pick(Splines{}, spline, f);
}

}  // namespace neve
