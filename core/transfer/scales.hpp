// The lengths and shares that transfers multiply with: rounded once a step, so that no particle divides.
#pragma once

#include "math/real.hpp"

namespace neve {

// Of a grid of cells dx.
template <class T>
struct CellScales {
  T dx;        // [m]
  T gradient;  // 1 / dx [1/m]: of sums with the weights' gradients per cell
  T affine;    // dx D^-1 [1/m]: of sums with w (x_i - x_p) / dx

  template <class Spline>
  static CellScales of(double dx) {
    return {T(dx), T(1 / dx), T(Spline::inverse_inertia / dx)};
  }
};

// How much of a particle's new velocity is FLIP and how much PIC.
template <class T>
struct FlipBlend {
  T flip, pic;

  static FlipBlend of(double alpha) { return {T(alpha), T(1 - alpha)}; }
};

}  // namespace neve
