// From the model's words to the templates: one line per spline, transfer and law.
#pragma once

#include "mpm/p2g.hpp"
#include "mpm/particles.hpp"

namespace neve {

using Law = Stomakhin2013;

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

}  // namespace neve
