// The smaller, the larger, the size, of scalars and packs.
#pragma once

#include "math/scalar.hpp"
#if !defined(__CUDACC_RTC__)
#include "math/pack.hpp"  // a device has no packs: there each particle is a scalar of its own
#endif

namespace neve {

template <class R>
NEVE_INLINE R min(const R& a, const R& b) {
  return select(a < b, a, b);
}
template <class R>
NEVE_INLINE R max(const R& a, const R& b) {
  return select(a > b, a, b);
}
template <class R>
NEVE_INLINE R clamp(const R& a, const R& low, const R& high) {
  return min(max(a, low), high);
}
template <class R>
NEVE_INLINE R abs(const R& a) {
  return max(a, R(-a));
}

}  // namespace neve
