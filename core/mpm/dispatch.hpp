// From the model's choices to the templates.
#pragma once

#include "math/bspline.hpp"
#include "mpm/model.hpp"
#include "transfer/transfers.hpp"

namespace neve {

template <class T, class F>
auto with_transfer(const Model<T>& model, F&& f) {
  return with_transfer(model.transfer, model.polypic_modes, f);
}

// Whether particles carry an affine velocity.
template <class T>
bool keeps_C(const Model<T>& model) {
  return with_transfer(model, [](auto x) { return decltype(x)::keeps_C; });
}

// Whether the transfer keeps force and change of velocity in a second array of the grid.
template <class T>
bool keeps_change(const Model<T>& model) {
  return with_transfer(model, [](auto x) { return decltype(x)::has_change; });
}

// Whether some solid has play.
template <class T>
bool has_play(const Model<T>& model) {
  for (const auto& solid : model.solids) {
    if (has_play(solid.mode, solid.mu_c)) return true;
  }
  return false;
}

// How many velocity modes a particle has beyond v and C.
template <class T>
int more_modes(const Model<T>& model) {
  return with_transfer(model, [](auto x) { return decltype(x)::modes - 4; });
}

// How stiff the stress of a particle alone makes the nodes around it: w^2 <= stiffness 3 K V0 / (m dx^2) [1].
template <class T>
double stencil_stiffness(const Model<T>& model) {
  return with_spline(model.spline, [&](auto spline) {
    return with_transfer(
        model, [](auto x) { return decltype(x)::ScatterWeights::template stiffness<decltype(spline)>; });
  });
}

// How many velocities a particle has in `modes`: the further modes, and how far it has left surfaces with play.
template <class T>
int velocities(const Model<T>& model) {
  return more_modes(model) + has_play(model);
}

}  // namespace neve
