// What the kernels are compiled for: one precision, spline and transfer, the laws of one material table, and whether there
// are solids. All of it is known before a run, so that a kernel holds no branch that is never taken.
#pragma once

#include "constitutive/laws.hpp"
#include "cuda/grid/sum.hpp"
#include "math/bspline.hpp"
#include "transfer/transfers.hpp"

namespace neve::cuda {

// The transfer that an item of Transfers stands for with so many modes.
template <class X, int modes>
struct OfModes {
  using type = X;
};
template <class X, int modes>
  requires requires { typename X::template Of<modes>; }
struct OfModes<X, modes> {
  using type = typename X::template Of<modes>;
};

// spline, transfer: places in Splines and Transfers; laws: a bit for each place in Laws; solids: whether there are any;
// play: whether one of them has play; deterministic: whether sums have the same bits in every run; fused: whether g2p2g takes
// the place of g2p and the next p2g (cuda/g2p2g.hpp).
template <class Real, int spline, int transfer, int modes, unsigned laws_, bool solids, bool play,
          bool deterministic, bool fused = false>
struct Choice {
  using T = Real;
  using Spline = item_at<spline, Splines>;
  using Transfer = typename OfModes<item_at<transfer, Transfers>, modes>::type;
  static constexpr unsigned laws = laws_;
  static constexpr bool has_solids = solids, has_play = play, is_deterministic = deterministic;
  using Number = Sum<deterministic>;
  static constexpr bool has_change = Transfer::has_change;
  static constexpr bool is_fused = fused;
  static constexpr bool has_force = has_change || fused;  // it comes to the nodes apart from momentum
};

}  // namespace neve::cuda
