// PolyPIC (Fu et al. 2017): beside v and C a particle carries more coefficients c_r of a polynomial velocity field, in
// the modes s_r of modes.hpp; with the MLS-MPM stress on the linear ones, as APIC. Q degrees per axis: 2 keeps the
// multilinear modes (8), 3 the quadratic ones (27). From the paper's idea; its details were not at hand.
//
//   (m v)_i = sum_p w_ip [ m_p sum_r c_pr s_r(x_i - x_p) - dt V0_p D^-1 tau_p (x_i - x_p) ]
//   c_pr = sum_i w_ip s_r v_i / sum_i w_ip s_r^2
#pragma once

#include <type_traits>

#include "mpm/modes.hpp"
#include "mpm/transfer/apic.hpp"
#include "mpm/transfer/pic.hpp"

namespace neve {

template <int Q>
struct Polypic : Apic {
  static constexpr int modes = Q * Q * Q;
  static constexpr bool squares = Q > 2;
  static constexpr auto& order = modes_of<Q>;
  using To = std::conditional_t<Q == 2, AffineWeights, QuadraticWeights>;
  using From = std::conditional_t<Q == 2, AffineWeights, QuadraticDuals>;

  // What turns the gathered sum of mode n into its coefficient: 1 / sum w z^2 for each degree 1.
  template <class S>
  static constexpr double scale(int n) {
    double scale = 1;
    for (int degree : order[static_cast<std::size_t>(n)].degree)
      scale *= degree == 1 ? S::inverse_inertia : 1;
    return scale;
  }
};

// The word in a scene: with one mode per axis it is PIC, and with v and C alone it is APIC.
struct PolypicOfModes : Polypic<2> {
  static constexpr Word word{"polypic", "keeps angular momentum, and finer motions too",
                             "Fu et al. 2017 names the idea, the details are ours",
                             "fu2017 jiang2015 hu2018"};
  static constexpr const char* options = "polypic_modes";

  template <class F>
  static auto of_modes(int modes, F&& f) {
    if (modes == 1) return f(Pic{});
    if (modes == 8) return f(Polypic<2>{});
    if (modes == 27) return f(Polypic<3>{});
    return f(Apic{});
  }
};

}  // namespace neve
