// PolyPIC (Fu et al. 2017): beside v and C a particle carries more coefficients c_r of a polynomial velocity field, in
// the modes s_r of modes.hpp; with the MLS-MPM stress on the linear ones, as APIC. Q degrees per axis: 2 keeps the
// multilinear modes (8), 3 the quadratic ones (27). From the paper's idea; its details were not at hand.
//
//   (m v)_i = sum_p w_ip [ m_p sum_r c_pr s_r(x_i - x_p) - dt V0_p D^-1 tau_p (x_i - x_p) ]
//   c_pr = sum_i w_ip s_r v_i / sum_i w_ip s_r^2
#pragma once

#include "transfer/apic.hpp"
#include "transfer/modes.hpp"
#include "transfer/pic.hpp"

namespace neve {

template <int Q>
struct Polypic : Apic {
  static constexpr int modes = Q * Q * Q;
  static constexpr bool squares = Q > 2;
  static constexpr auto& order = modes_of<Q>;
  using ScatterWeights = std::conditional_t<Q == 2, AffineWeights, QuadraticWeights>;
  using GatherWeights = std::conditional_t<Q == 2, AffineWeights, QuadraticDuals>;

  // What turns the gathered sum of mode n into its coefficient: 1 / sum w z^2 for each degree 1.
  template <class S>
  static constexpr double scale(int n) {
    double scale = 1;
    for (int degree : order[n].degree) scale *= degree == 1 ? S::inverse_inertia : 1;
    return scale;
  }

  // The coefficient of a mode beyond v and C from its gathered sum; `kept` of each axis by kept().
  template <class S, class R>
  NEVE_INLINE static Vec3<R> coefficient(int n, const Vec3<R>& sum, const Vec3<R>& kept) {
    Vec3<R> c = sum * scalar_t<R>(scale<S>(n));
    if constexpr (squares) {
      for (int a = 0; a < 3; ++a) {
        if (order[n].degree[a] == 2) c = c * kept[a];
      }
    }
    return c;
  }

  // What is kept of an axis' square modes when the particle moves from one fraction of a cell to another. On its way it
  // takes them to where they weigh more or less: where more, they are scaled down, so that moving never adds energy.
  template <class S, class R>
  NEVE_INLINE static R kept(R from, R to) {
    const R before = square_norm<S>(from), after = square_norm<S>(to);
    return select(after > before, sqrt(before / select(after > R{}, after, splat<R>(1))), splat<R>(1));
  }
};

// The word in a scene: with one mode per axis it is PIC, and with v and C alone it is APIC.
struct PolypicOfModes : Polypic<2> {
  static constexpr Word word{"polypic", "keeps angular momentum, and finer motions too",
                             "Fu et al. 2017 names the idea, the details are ours",
                             "fu2017 jiang2015 hu2018"};
  static constexpr const char* options = "polypic_modes";

  template <int modes>
  using Of = std::conditional_t<
      modes == 1, Pic,
      std::conditional_t<modes == 8, Polypic<2>, std::conditional_t<modes == 27, Polypic<3>, Apic>>>;

  template <class F>
  static auto of_modes(int modes, F&& f) {
    if (modes == 1) return f(Of<1>{});
    if (modes == 8) return f(Of<8>{});
    if (modes == 27) return f(Of<27>{});
    return f(Of<4>{});
  }
};

}  // namespace neve
