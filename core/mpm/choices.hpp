// From the model's words to the templates: one line per spline and transfer. (Laws: mpm/material.hpp.)
#pragma once

#include "math/bspline.hpp"
#include "mpm/transfer/apic.hpp"
#include "mpm/transfer/asflip.hpp"
#include "mpm/transfer/flip.hpp"
#include "mpm/transfer/pic.hpp"
#include "mpm/transfer/polypic.hpp"

namespace neve {

template <class F>
auto with_spline(Spline spline, F&& f) {
  switch (spline) {
    case Spline::cubic: return f(Cubic{});
    case Spline::quadratic: break;
  }
  return f(Quadratic{});
}

// With one mode per axis polypic is PIC, and with v and C alone it is APIC.
template <class T, class F>
auto with_transfer(const Model<T>& model, F&& f) {
  switch (model.transfer) {
    case Transfer::pic: return f(Pic{});
    case Transfer::flip: return f(Flip{});
    case Transfer::asflip: return f(Asflip{});
    case Transfer::polypic:
      if (model.polypic_modes == 1) return f(Pic{});
      if (model.polypic_modes == 8) return f(Polypic<2>{});
      if (model.polypic_modes == 27) return f(Polypic<3>{});
      break;
    case Transfer::apic: break;
  }
  return f(Apic{});
}

// Whether the transfer keeps force and change of velocity in a second array of the grid.
template <class T>
bool keeps_change(const Model<T>& model) {
  return with_transfer(model, [](auto x) { return decltype(x)::has_change; });
}

// How many velocity modes a particle has beyond v and C.
template <class T>
int more_modes(const Model<T>& model) {
  return with_transfer(model, [](auto x) { return decltype(x)::modes - 4; });
}

}  // namespace neve
