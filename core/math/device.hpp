// Those parts of the standard library that the physics uses, for NVRTC, which brings no library along.
#pragma once

namespace std {

using size_t = decltype(sizeof(0));
using int32_t = int;
using uint32_t = unsigned;

template <class A, class B>
inline constexpr bool is_same_v = false;
template <class A>
inline constexpr bool is_same_v<A, A> = true;
template <class A>
inline constexpr bool is_arithmetic_v = is_same_v<A, bool> || is_same_v<A, int> || is_same_v<A, unsigned> ||
                                        is_same_v<A, float> || is_same_v<A, double>;

template <bool, class A, class>
struct conditional {
  using type = A;
};
template <class A, class B>
struct conditional<false, A, B> {
  using type = B;
};
template <bool C, class A, class B>
using conditional_t = typename conditional<C, A, B>::type;

template <class A>
struct numeric_limits;
template <>
struct numeric_limits<float> {
  static constexpr int digits = 24;
  static constexpr float min() { return 1.17549435e-38f; }
  static constexpr float max() { return 3.40282347e+38f; }
  static constexpr float epsilon() { return 1.1920929e-7f; }
};
template <>
struct numeric_limits<double> {
  static constexpr int digits = 53;
  static constexpr double min() { return 2.2250738585072014e-308; }
  static constexpr double max() { return 1.7976931348623157e+308; }
  static constexpr double epsilon() { return 2.2204460492503131e-16; }
  static double infinity() { return __longlong_as_double(0x7ff0000000000000LL); }
};
template <>
struct numeric_limits<uint32_t> {
  static constexpr uint32_t max() { return 0xffffffffu; }
};

template <class A>
constexpr const A& min(const A& a, const A& b) {
  return b < a ? b : a;
}
template <class A>
constexpr const A& max(const A& a, const A& b) {
  return a < b ? b : a;
}
template <class A>
constexpr const A& clamp(const A& a, const A& low, const A& high) {
  return a < low ? low : high < a ? high : a;
}

using ::ceil, ::exp, ::expm1, ::floor, ::log, ::log1p, ::memcpy, ::sin, ::sqrt, ::tan;

}  // namespace std
