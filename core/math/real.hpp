// All that the physics does with its real type R, which is a scalar or, on a host, a lane pack.
#pragma once

#include "math/compare.hpp"
#include "math/scalar.hpp"
#if !defined(__CUDACC_RTC__)
#include "math/functions.hpp"
#include "math/pack.hpp"
#include "math/rows.hpp"
#endif

namespace neve {

// Return sinh(a) and its inverse for a >= 0, precise near zero.
template <class R>
NEVE_INLINE R sinh_positive(const R& a) {
  const R t = expm1(a);
  return (t + t / (t + scalar_t<R>(1))) * scalar_t<R>(0.5);
}
template <class R>
NEVE_INLINE R asinh_positive(const R& a) {
  const R one = splat<R>(1);
  return log1p(R(a + a * (a / (one + sqrt(R(one + a * a))))));
}

}  // namespace neve
