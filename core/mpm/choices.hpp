// From the model's words to the templates: one line per spline and transfer. (Laws: mpm/material.hpp.)
#pragma once

#include "math/bspline.hpp"
#include "mpm/transfer/apic.hpp"
#include "mpm/transfer/flip.hpp"

namespace neve {

template <class F>
auto with_spline(Spline spline, F&& f) {
  switch (spline) {
    case Spline::cubic: return f(Cubic{});
    case Spline::quadratic: break;
  }
  return f(Quadratic{});
}

template <class F>
auto with_transfer(Transfer transfer, F&& f) {
  switch (transfer) {
    case Transfer::flip: return f(Flip{});
    case Transfer::apic: break;
  }
  return f(Apic{});
}

// Whether the transfer keeps force and change of velocity in a second array of the grid.
inline bool keeps_change(Transfer transfer) {
  return with_transfer(transfer, [](auto x) { return decltype(x)::has_change; });
}

}  // namespace neve
