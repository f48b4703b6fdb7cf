// Scalars as the real type R of the physics. It is written once for R a plain `float` or `double`, here, and for a pack of
// them, one per SIMD lane (pack.hpp).
#pragma once

#include "math/inline.hpp"
#include "math/standard.hpp"

namespace neve {

// The type of the numbers in R.
template <class R>
struct Scalar;
template <>
struct Scalar<float> {
  using type = float;
};
template <>
struct Scalar<double> {
  using type = double;
};
template <class R>
using scalar_t = typename Scalar<R>::type;
template <class R>
concept IsScalar = std::is_arithmetic_v<R>;
template <class R>
concept IsPack = !IsScalar<R>;
template <class R>
inline constexpr bool is_pack = IsPack<R>;
// How many numbers R has.
template <class R>
inline constexpr int width = static_cast<int>(sizeof(R) / sizeof(scalar_t<R>));

// The same number in every lane.
template <IsScalar R>
NEVE_INLINE R splat(scalar_t<R> a) {
  return a;
}

// Masks are comparisons, and comparisons joined by & and |: of scalars a bool, or an int where two are joined.
template <IsScalar R, class M>
NEVE_INLINE R select(const M& mask, const R& yes, const R& no) {
  return mask ? yes : no;
}
template <IsScalar M>
NEVE_INLINE bool any(const M& mask) {
  return mask != 0;
}
template <IsScalar M>
NEVE_INLINE bool negated(const M& mask) {
  return mask == 0;
}

// The same numbers in double precision.
template <class R>
struct DoublesOf {
  using type = double;
};
template <class R>
using Doubles = typename DoublesOf<R>::type;
template <IsScalar R>
NEVE_INLINE double doubles(const R& a) {
  return a;
}

// Call f(lane) for each lane of a mask.
template <IsScalar M, class F>
NEVE_INLINE void for_lanes(const M& mask, F&& f) {
  if (mask) f(0);
}

template <IsScalar R>
NEVE_INLINE R max_lane(const R& a) {
  return a;
}

template <IsScalar R>
NEVE_INLINE R sqrt(const R& a) {
  return std::sqrt(a);
}
template <IsScalar R>
NEVE_INLINE R floor(const R& a) {
  return std::floor(a);
}
// Return 1/sqrt(a) for a > 0, to 14 bits or better.
template <IsScalar R>
NEVE_INLINE R rough_rsqrt(const R& a) {
  return R(1) / std::sqrt(a);
}
// Return 1/sqrt(a) for a > 0, within 2 ulp.
template <IsScalar R>
NEVE_INLINE R rsqrt(const R& a) {
  return R(1) / std::sqrt(a);
}
// Return 1/a, within 2 ulp.
template <IsScalar R>
NEVE_INLINE R reciprocal(const R& a) {
  return R(1) / a;
}
template <IsScalar R>
NEVE_INLINE R exp(const R& a) {
  return std::exp(a);
}
template <IsScalar R>
NEVE_INLINE R expm1(const R& a) {
  return std::expm1(a);
}
template <IsScalar R>
NEVE_INLINE R log1p(const R& a) {
  return std::log1p(a);
}

}  // namespace neve
