// Lane packs: a fixed number of numbers that move together, one per SIMD lane.
//
// The physics is written once for a real type R that is a plain `float` or `double`, or a pack of them
// (GNU vector extensions: GCC and Clang, x86 and Arm; a pack wider than the machine's registers is split
// by the compiler). The functions below are all that arithmetic operators do not give.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace neve {

template <class T, int N>
struct PackOf {
  typedef T type __attribute__((vector_size(N * sizeof(T))));
};
template <class T, int N>
using Pack = typename PackOf<T, N>::type;

// Particles per batch: one cache line of scalars.
template <class T>
inline constexpr int lane_count = 64 / static_cast<int>(sizeof(T));
template <class T>
using Lanes = Pack<T, lane_count<T>>;

template <class R>
struct Scalar {
  using type = std::remove_cvref_t<decltype(std::declval<R>()[0])>;
};
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
inline constexpr bool is_pack = !std::is_arithmetic_v<R>;
template <class R>
inline constexpr int width = static_cast<int>(sizeof(R) / sizeof(scalar_t<R>));

template <class R>
inline R splat(scalar_t<R> a) {
  if constexpr (is_pack<R>) {
    return R{} + a;
  } else {
    return a;
  }
}

template <class R, class M>
inline R select(M mask, R yes, R no) {
  return mask ? yes : no;
}

template <class M>
inline bool any(M mask) {
  if constexpr (std::is_same_v<M, bool>) {
    return mask;
  } else {
#if defined(__AVX512F__)
    if constexpr (sizeof(M) == 64) {
      const auto m = reinterpret_cast<__m512i>(mask);
      return _mm512_test_epi32_mask(m, m) != 0;
    }
#endif
    std::uint64_t words[sizeof(M) / 8], bits = 0;
    std::memcpy(words, &mask, sizeof(M));
    for (std::uint64_t w : words) bits |= w;
    return bits != 0;
  }
}

template <class R>
inline R min(R a, R b) {
  return select(a < b, a, b);
}
template <class R>
inline R max(R a, R b) {
  return select(a > b, a, b);
}
template <class R>
inline R clamp(R a, R low, R high) {
  return min(max(a, low), high);
}
template <class R>
inline R abs(R a) {
  return max(a, -a);
}

template <class R>
inline scalar_t<R> max_lane(R a) {
  if constexpr (is_pack<R>) {
    using T = scalar_t<R>;
    alignas(sizeof(R)) T v[width<R>];
    std::memcpy(v, &a, sizeof(R));
    for (int n = width<R> / 2; n > 0; n /= 2) {  // halves, so that the comparisons are packs
      for (int i = 0; i < n; ++i) v[i] = v[i + n] > v[i] ? v[i + n] : v[i];
    }
    return v[0];
  } else {
    return a;
  }
}

template <class R>
inline R sqrt(R a) {
  if constexpr (!is_pack<R>) {
    return std::sqrt(a);
#if defined(__AVX512F__)
  } else if constexpr (std::is_same_v<R, Pack<float, 16>>) {
    return reinterpret_cast<R>(_mm512_sqrt_ps(reinterpret_cast<__m512>(a)));
  } else if constexpr (std::is_same_v<R, Pack<double, 8>>) {
    return reinterpret_cast<R>(_mm512_sqrt_pd(reinterpret_cast<__m512d>(a)));
#endif
  } else {
    for (int i = 0; i < width<R>; ++i) a[i] = std::sqrt(a[i]);
    return a;
  }
}

// Return 1/sqrt(a) for a > 0, to 14 bits or better.
template <class R>
inline R rough_rsqrt(R a) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<R, Pack<float, 16>>) {
    return reinterpret_cast<R>(_mm512_rsqrt14_ps(reinterpret_cast<__m512>(a)));
  }
#endif
  return scalar_t<R>(1) / sqrt(a);
}

// Return 1/sqrt(a) for a > 0, to rounding in double and within 2 ulp in float.
template <class R>
inline R rsqrt(R a) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<R, Pack<float, 16>>) {
    const R y = rough_rsqrt(a);
    return y * (1.5f - (0.5f * a) * y * y);  // one Newton step: 14 bits to 24
  }
#endif
  return rough_rsqrt(a);
}

template <class R>
inline R floor(R a) {
  if constexpr (!is_pack<R>) {
    return std::floor(a);
#if defined(__AVX512F__)
  } else if constexpr (std::is_same_v<R, Pack<float, 16>>) {
    return reinterpret_cast<R>(_mm512_floor_ps(reinterpret_cast<__m512>(a)));
  } else if constexpr (std::is_same_v<R, Pack<double, 8>>) {
    return reinterpret_cast<R>(_mm512_floor_pd(reinterpret_cast<__m512d>(a)));
#endif
  } else {
    for (int i = 0; i < width<R>; ++i) a[i] = std::floor(a[i]);
    return a;
  }
}

// Return exp(a). In float lanes: a = n ln 2 + r, |r| <= ln 2 / 2, a degree-6 polynomial in r, error < 2e-7.
template <class R>
inline R exp(R a) {
  if constexpr (!is_pack<R>) {
    return std::exp(a);
  } else if constexpr (std::is_same_v<scalar_t<R>, float>) {
    a = clamp(a, splat<R>(-87.0f), splat<R>(88.0f));
    const R n = floor(a * 1.44269504f + 0.5f);
    const R r = (a - n * 0.693359375f) + n * 2.12194440e-4f;
    R p = splat<R>(1.0f / 720);
    for (float c : {1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f, 1.0f}) p = p * r + c;
    using Ints = Pack<std::int32_t, width<R>>;
    const Ints bits = (__builtin_convertvector(n, Ints) + 127) << 23;
    return p * reinterpret_cast<R>(bits);
  } else {
    for (int i = 0; i < width<R>; ++i) a[i] = std::exp(a[i]);
    return a;
  }
}

// Return exp(a) - 1, precise near zero. In float lanes: a = n ln 2 + r as in exp, a degree-7 polynomial for
// exp(r) - 1, and exp(a) - 1 = 2^n (exp(r) - 1) + (2^n - 1); error < 3 eps of the result.
template <class R>
inline R expm1(R a) {
  if constexpr (!is_pack<R>) {
    return std::expm1(a);
  } else if constexpr (std::is_same_v<scalar_t<R>, float>) {
    a = clamp(a, splat<R>(-87.0f), splat<R>(88.0f));
    const R n = floor(a * 1.44269504f + 0.5f);
    const R r = (a - n * 0.693359375f) + n * 2.12194440e-4f;
    R p = splat<R>(1.0f / 5040);
    for (float c : {1.0f / 720, 1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f}) p = p * r + c;
    using Ints = Pack<std::int32_t, width<R>>;
    const Ints bits = (__builtin_convertvector(n, Ints) + 127) << 23;
    const R power = reinterpret_cast<R>(bits);
    return power * (r + r * r * p) + (power - 1.0f);
  } else {
    for (int i = 0; i < width<R>; ++i) a[i] = std::expm1(a[i]);
    return a;
  }
}

// Return log(1 + a) for a > -1, precise near zero. In float lanes: 1 + a = u + lost exactly, u = 2^n (1 + f) with
// 1 + f between 1/sqrt 2 and sqrt 2, log(1 + f) = 2 artanh(s) = 2 (s + s^3/3 + s^5/5 ...), s = f / (2 + f), where
// s^2 < 0.03 makes five terms enough; 2 s is written f - s f, so that f leads without rounding. Error < 3 eps.
template <class R>
inline R log1p(R a) {
  if constexpr (!is_pack<R>) {
    return std::log1p(a);
  } else if constexpr (std::is_same_v<scalar_t<R>, float>) {
    using Ints = Pack<std::int32_t, width<R>>;
    constexpr std::int32_t root_half = 0x3f3504f3;  // the bits of 1/sqrt 2
    const R u = a + 1.0f, most = u - 1.0f;
    const R lost = (1.0f - (u - most)) + (a - most);
    const Ints bits = reinterpret_cast<Ints>(u) - root_half;
    const R n = __builtin_convertvector(bits >> 23, R);
    const R f = reinterpret_cast<R>((bits & 0x7fffff) + root_half) - 1.0f;
    const R s = f / (f + 2.0f), z = s * s;
    R w = splat<R>(2.0f / 9);
    for (float c : {2.0f / 7, 2.0f / 5, 2.0f / 3}) w = w * z + c;
    return n * 0.693359375f + ((f - s * (f - w * z)) + (lost / u - n * 2.12194440e-4f));
  } else {
    for (int i = 0; i < width<R>; ++i) a[i] = std::log1p(a[i]);
    return a;
  }
}

// Return sinh(a) and its inverse for a >= 0, precise near zero.
template <class R>
inline R sinh_positive(R a) {
  const R t = expm1(a);
  return (t + t / (t + scalar_t<R>(1))) * scalar_t<R>(0.5);
}
template <class R>
inline R asinh_positive(R a) {
  const R one = splat<R>(1);
  return log1p(a + a * (a / (one + sqrt(one + a * a))));
}

// ---- memory ----

// Load `count` lanes; the lanes beyond stay zero.
template <class R>
inline R load(const scalar_t<R>* from, int count = width<R>) {
  R r{};
  if (count == width<R>) {
    std::memcpy(&r, from, sizeof(R));
#if defined(__AVX512F__)
  } else if constexpr (std::is_same_v<R, Pack<float, 16>>) {
    r = reinterpret_cast<R>(_mm512_maskz_loadu_ps(static_cast<__mmask16>((1u << count) - 1), from));
#endif
  } else {
    std::memcpy(&r, from, static_cast<std::size_t>(count) * sizeof(scalar_t<R>));
  }
  return r;
}

template <class R>
inline void store(scalar_t<R>* to, R a, int count = width<R>) {
  if (count == width<R>) {
    std::memcpy(to, &a, sizeof(R));
#if defined(__AVX512F__)
  } else if constexpr (std::is_same_v<R, Pack<float, 16>>) {
    _mm512_mask_storeu_ps(to, static_cast<__mmask16>((1u << count) - 1), reinterpret_cast<__m512>(a));
#endif
  } else {
    std::memcpy(to, &a, static_cast<std::size_t>(count) * sizeof(scalar_t<R>));
  }
}

// The mask of the first `count` lanes.
template <class R>
inline auto first_lanes(int count) {
  using T = scalar_t<R>;
  alignas(64) static constexpr auto index = []<int... I>(std::integer_sequence<int, I...>) {
    return std::array<T, sizeof...(I)>{T(I)...};
  }(std::make_integer_sequence<int, width<R>>{});
  return load<R>(index.data()) < T(count);
}

namespace detail {
template <class R, int Start, std::size_t... I>
inline R interleave_from(R a, R b, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, b, (Start + static_cast<int>(I) / 2 + (I % 2) * sizeof...(I))...);
}
template <class R, int Start, std::size_t... I>
inline R pairs_from(R a, R b, std::index_sequence<I...>) {
  return __builtin_shufflevector(
      a, b,
      (Start + 2 * (static_cast<int>(I) / 4) + static_cast<int>(I) % 2 + ((I / 2) % 2) * sizeof...(I))...);
}
template <class R, int Start, std::size_t... I>
inline R every_other(R a, R b, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, b, (Start + 2 * static_cast<int>(I))...);
}
}  // namespace detail

// Write four packs as an array of `width` quadruples: out[4 l + k] = k-th pack's lane l.
template <class R>
inline void store_quads(scalar_t<R>* out, R a, R b, R c, R d) {
  constexpr int n = width<R>;
  constexpr auto seq = std::make_index_sequence<n>{};
  const R ab0 = detail::interleave_from<R, 0>(a, b, seq), ab1 = detail::interleave_from<R, n / 2>(a, b, seq);
  const R cd0 = detail::interleave_from<R, 0>(c, d, seq), cd1 = detail::interleave_from<R, n / 2>(c, d, seq);
  store(out, detail::pairs_from<R, 0>(ab0, cd0, seq));
  store(out + n, detail::pairs_from<R, n / 2>(ab0, cd0, seq));
  store(out + 2 * n, detail::pairs_from<R, 0>(ab1, cd1, seq));
  store(out + 3 * n, detail::pairs_from<R, n / 2>(ab1, cd1, seq));
}

// Read back what store_quads wrote.
template <class R>
inline void load_quads(const scalar_t<R>* in, R& a, R& b, R& c, R& d) {
  constexpr int n = width<R>;
  constexpr auto seq = std::make_index_sequence<n>{};
  const R p0 = load<R>(in), p1 = load<R>(in + n), p2 = load<R>(in + 2 * n), p3 = load<R>(in + 3 * n);
  const R ac0 = detail::every_other<R, 0>(p0, p1, seq), bd0 = detail::every_other<R, 1>(p0, p1, seq);
  const R ac1 = detail::every_other<R, 0>(p2, p3, seq), bd1 = detail::every_other<R, 1>(p2, p3, seq);
  a = detail::every_other<R, 0>(ac0, ac1, seq);
  c = detail::every_other<R, 1>(ac0, ac1, seq);
  b = detail::every_other<R, 0>(bd0, bd1, seq);
  d = detail::every_other<R, 1>(bd0, bd1, seq);
}

// ---- rows: four neighbouring nodes of four numbers each ----

template <class T>
using Row = Pack<T, 16>;

template <class T>
inline Row<T> row_of_quad(const T* q) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<T, float>) {
    return reinterpret_cast<Row<T>>(_mm512_broadcast_f32x4(_mm_loadu_ps(q)));
  }
#endif
  return Row<T>{q[0], q[1], q[2], q[3], q[0], q[1], q[2], q[3],
                q[0], q[1], q[2], q[3], q[0], q[1], q[2], q[3]};
}
template <class T>
inline Row<T> row_of_weights(const T* w) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<T, float>) {
    const __m512i each = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
    return reinterpret_cast<Row<T>>(_mm512_permutexvar_ps(each, _mm512_castps128_ps512(_mm_loadu_ps(w))));
  }
#endif
  return Row<T>{w[0], w[0], w[0], w[0], w[1], w[1], w[1], w[1],
                w[2], w[2], w[2], w[2], w[3], w[3], w[3], w[3]};
}
template <class T>
inline Row<T> last_of_quads(Row<T> a) {
  return __builtin_shufflevector(a, a, 3, 3, 3, 3, 7, 7, 7, 7, 11, 11, 11, 11, 15, 15, 15, 15);
}
// Turn a row by one half and by a quarter: with two maxima every quad holds the maximum over the four nodes.
template <class T>
inline Row<T> max_of_nodes(Row<T> a) {
  a = max(a, __builtin_shufflevector(a, a, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7));
  return max(a, __builtin_shufflevector(a, a, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3));
}
// Sum the four nodes of each of four rows: the result holds the sums of a, b, c, d as four quads.
template <class T>
inline Row<T> sum_nodes(Row<T> a, Row<T> b, Row<T> c, Row<T> d) {
  const Row<T> ab =
      __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
      __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
  const Row<T> cd =
      __builtin_shufflevector(c, d, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
      __builtin_shufflevector(c, d, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
  return __builtin_shufflevector(ab, cd, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27) +
         __builtin_shufflevector(ab, cd, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31);
}

}  // namespace neve
