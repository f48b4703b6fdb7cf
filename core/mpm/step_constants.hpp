// What is the same for every particle of a step.
#pragma once

#include "coupling/contacts.hpp"
#include "transfer/scales.hpp"

namespace neve {

template <class T>
struct StepConstants {
  T dt;  // [s]
  CellScales<T> cells;
  FlipBlend<T> blend;
  T skin;  // how far outside a solid still counts as held by it [m]

  // `alpha`: the share of FLIP in this step.
  template <class Spline>
  static StepConstants of(double dx, double dt, double alpha) {
    return {T(dt), CellScales<T>::template of<Spline>(dx), FlipBlend<T>::of(alpha), T(skin_cells * dx)};
  }
};

}  // namespace neve
