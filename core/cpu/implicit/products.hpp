// Products of matrices that implicit steps have besides.
#pragma once

#include "math/mat3.hpp"

namespace neve::detail {

// A B^T.
template <class R>
NEVE_INLINE Mat3<R> times_transposed(const Mat3<R>& a, const Mat3<R>& b) {
  Mat3<R> out;
  for (int j = 0; j < 3; ++j) out.column(j) = a.c0 * b.c0[j] + a.c1 * b.c1[j] + a.c2 * b.c2[j];
  return out;
}

// F^-T.
template <class R>
Mat3<R> inverse_transposed(const Mat3<R>& a) {
  const R d = splat<R>(1) / determinant(a);
  return {cross(a.c1, a.c2) * d, cross(a.c2, a.c0) * d, cross(a.c0, a.c1) * d};
}

}  // namespace neve::detail
