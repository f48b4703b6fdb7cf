// The smaller, the larger, the size, of scalars and packs.
#pragma once

#include "math/scalar.hpp"
#if !defined(__CUDACC_RTC__)
#include "math/pack.hpp"  // a device has no packs: there each particle is a scalar of its own
#endif

namespace neve {

namespace detail {

// a where a < b and b elsewhere, so also where one of them is not a number; and the same with a > b. x86 has instructions for
// just that, which GCC does not always find.
template <class R>
NEVE_INLINE R smaller(const R& a, const R& b) {
#if defined(__AVX2__) && !defined(__CUDACC_RTC__)
  if constexpr (std::is_same_v<R, Pack<float, 8>>)
    return reinterpret_cast<R>(_mm256_min_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
  if constexpr (std::is_same_v<R, Pack<double, 4>>)
    return reinterpret_cast<R>(_mm256_min_pd(reinterpret_cast<__m256d>(a), reinterpret_cast<__m256d>(b)));
#endif
  return select(a < b, a, b);
}
template <class R>
NEVE_INLINE R larger(const R& a, const R& b) {
#if defined(__AVX2__) && !defined(__CUDACC_RTC__)
  if constexpr (std::is_same_v<R, Pack<float, 8>>)
    return reinterpret_cast<R>(_mm256_max_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
  if constexpr (std::is_same_v<R, Pack<double, 4>>)
    return reinterpret_cast<R>(_mm256_max_pd(reinterpret_cast<__m256d>(a), reinterpret_cast<__m256d>(b)));
#endif
  return select(a > b, a, b);
}

}  // namespace detail

template <class R>
NEVE_INLINE R min(const R& a, const R& b) {
  return detail::smaller(a, b);
}
template <class R>
NEVE_INLINE R max(const R& a, const R& b) {
  return detail::larger(a, b);
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
