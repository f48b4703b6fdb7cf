// Samples of a grid: quads of four floats, read and blended one point after another.
#pragma once

#include "math/mat3.hpp"

namespace neve {

namespace detail {

// Lane l of a pack; of a scalar, the scalar.
template <class R>
inline scalar_t<R> lane(const R& a, int l) {
  if constexpr (is_pack<R>) {
    return a[l];
  } else {
    return a;
  }
}

template <class R>
inline void set_lane(R& a, int l, scalar_t<R> value) {
  if constexpr (is_pack<R>) {
    a[l] = value;
  } else {
    a = value;
  }
}

// Two neighbouring quads of floats, in the precision of the question.
#if defined(__CUDACC_RTC__)  // no vector types there
template <class T>
struct Quads {
  T value[8];
  T operator[](int k) const { return value[k]; }
  template <class F>
  static Quads each(F f) {
    return {{f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)}};
  }
  friend Quads operator+(const Quads& a, const Quads& b) {
    return each([&](int k) { return a[k] + b[k]; });
  }
  friend Quads operator-(const Quads& a, const Quads& b) {
    return each([&](int k) { return a[k] - b[k]; });
  }
  friend Quads operator*(const Quads& a, T t) {
    return each([&](int k) { return a[k] * t; });
  }
};
template <class T>
inline Quads<T> load_two_quads(const float* from) {
  return Quads<T>::each([&](int k) { return T(from[k]); });
}
#else
template <class T>
using Quads = Wide<T, 8>;
template <class T>
inline Quads<T> load_two_quads(const float* from) {
  using P = part_t<Quads<T>>;
  return each_part<register_count<Quads<T>>>([&](int k) NEVE_INLINE_LAMBDA {
    return __builtin_convertvector(load_registers<Pack<float, width<P>>>(from + k * width<P>), P);
  });
}
#endif

// The second of two quads counts by t, the first by 1 - t.
template <class T>
inline void store_blend(const Quads<T>& a, T t, T* quad) {
  for (int k = 0; k < 4; ++k) quad[k] = a[k] + (a[k + 4] - a[k]) * t;
}

// Take quads, one per lane, apart into four packs.
template <class R>
inline void packs_of_quads(const scalar_t<R>* quads, R& a, R& b, R& c, R& d) {
  if constexpr (is_pack<R>) {
    load_quads(quads, a, b, c, d);
  } else {
    a = quads[0], b = quads[1], c = quads[2], d = quads[3];
  }
}

}  // namespace detail

}  // namespace neve
