// The cubic spline kernel of smoothed particle hydrodynamics (Monaghan 1992), by its support.
#pragma once

#include "math/mat3.hpp"

namespace neve {

// With q = r / h and k = 8 / (pi h^3), zero from r = h on:
//
//   W = k (6 q^3 - 6 q^2 + 1) for q <= 1/2, else 2 k (1 - q)^3
//
// The gradient is slope(r^2) x for a point at x from the other; h is the support [m].
template <class T>
struct CubicKernel {
  T h{}, inverse{}, scale{};  // [m], [1/m], [1/m3]

  CubicKernel() = default;
  explicit CubicKernel(double support)
      : h(T(support)),
        inverse(T(1 / support)),
        scale(T(8 / (3.14159265358979323846 * support * support * support))) {}

  T at_zero() const { return scale; }

  template <class R>
  NEVE_INLINE R value(const R& r2) const {
    const R q = sqrt(r2) * inverse, left = max(T(1) - q, splat<R>(0));
    const R inner = q * q * (q - T(1)) * T(6) + T(1), outer = left * left * left * T(2);
    return select(q <= T(0.5), inner, outer) * scale;
  }

  // W' / r [1/m5].
  template <class R>
  NEVE_INLINE R slope(const R& r2) const {
    const R q = sqrt(r2) * inverse, left = max(T(1) - q, splat<R>(0));
    const R inner = q * T(3) - T(2), outer = left * left / max(q, splat<R>(T(0.25))) * T(-1);
    return select(q <= T(0.5), inner, outer) * (scale * T(6) * inverse * inverse);
  }
};

}  // namespace neve
