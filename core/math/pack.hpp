// Packs: a fixed number of numbers that move together, one per SIMD lane.
//
// GNU vector extensions: GCC and Clang, x86 and Arm. A vector is never wider than a register of the machine, because GCC
// passes wider ones through memory: a pack of more lanes is an array of registers, and every operation is one of each.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "math/scalar.hpp"

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace neve {

#if defined(__AVX512F__)
inline constexpr int register_bytes = 64;
#elif defined(__AVX2__)
inline constexpr int register_bytes = 32;
#else  // SSE, NEON
inline constexpr int register_bytes = 16;
#endif

template <class T, int N>
struct PackOf {
  typedef T type __attribute__((vector_size(N * sizeof(T))));
};
template <class T, int N>
using Pack = typename PackOf<T, N>::type;

// A register of numbers.
template <class T>
inline constexpr int register_lanes = register_bytes / static_cast<int>(sizeof(T));
template <class T>
using Register = Pack<T, register_lanes<T>>;

template <class R>
struct Scalar {
  using type = std::remove_cvref_t<decltype(std::declval<R>()[0])>;
};

// K registers that act as one.
template <class P, int K>
struct Registers {
  using T = std::remove_cvref_t<decltype(std::declval<P>()[0])>;
  P part[K];

  // One lane, for the rare places that look at them one by one.
  T operator[](int i) const { return part[i / lanes][i % lanes]; }
  T& operator[](int i) { return reinterpret_cast<T*>(part)[i]; }

 private:
  static constexpr int lanes = static_cast<int>(sizeof(P) / sizeof(T));
};
template <class R>
inline constexpr int register_count = 1;
template <class P, int K>
inline constexpr int register_count<Registers<P, K>> = K;

// N numbers: one register if it holds so many, else several.
template <class T, int N>
using Wide =
    std::conditional_t<(N > register_lanes<T>),
                       Registers<Register<T>, (N + register_lanes<T> - 1) / register_lanes<T>>, Pack<T, N>>;

// Particles per batch: a register of AVX2 and AVX-512, four of SSE or NEON. AVX2 has 16 registers, too few for what two packs
// hold.
template <class T>
inline constexpr int lane_count = (register_bytes == 32 ? 32 : 64) / static_cast<int>(sizeof(T));
template <class T>
using Lanes = Wide<T, lane_count<T>>;

// f(k) for each register of a pack, as a pack. A pack of one register is that register. (Written out by the front end:
// GCC unrolls loops too late to keep an array in registers.)
template <int K, class F>
NEVE_INLINE auto each_part(F&& f) {
  if constexpr (K == 1) {
    return f(0);
  } else {
    return [&]<int... k>(std::integer_sequence<int, k...>) NEVE_INLINE_LAMBDA {
      return Registers<decltype(f(0)), K>{{f(k)...}};
    }(std::make_integer_sequence<int, K>{});
  }
}
template <int K, class F>
NEVE_INLINE void for_parts(F&& f) {
  [&]<int... k>(std::integer_sequence<int, k...>)
      NEVE_INLINE_LAMBDA { (f(k), ...); }(std::make_integer_sequence<int, K>{});
}
template <class R>
NEVE_INLINE auto part_of(const R& a, int k) {
  if constexpr (register_count<R> == 1) {
    return a;
  } else {
    return a.part[k];
  }
}
template <class R>
using part_t = decltype(part_of(std::declval<R>(), 0));

#define NEVE_EACH_PART(OP)                                                                 \
  template <class P, int K>                                                                \
  NEVE_INLINE auto operator OP(const Registers<P, K>& a, const Registers<P, K>& b) {       \
    return each_part<K>([&](int k) NEVE_INLINE_LAMBDA { return a.part[k] OP b.part[k]; }); \
  }                                                                                        \
  template <class P, int K>                                                                \
  NEVE_INLINE auto operator OP(const Registers<P, K>& a, scalar_t<P> b) {                  \
    return each_part<K>([&](int k) NEVE_INLINE_LAMBDA { return a.part[k] OP b; });         \
  }                                                                                        \
  template <class P, int K>                                                                \
  NEVE_INLINE auto operator OP(scalar_t<P> a, const Registers<P, K>& b) {                  \
    return each_part<K>([&](int k) NEVE_INLINE_LAMBDA { return a OP b.part[k]; });         \
  }
NEVE_EACH_PART(+)
NEVE_EACH_PART(-)
NEVE_EACH_PART(*)
NEVE_EACH_PART(/)
NEVE_EACH_PART(<)
NEVE_EACH_PART(<=)
NEVE_EACH_PART(>)
NEVE_EACH_PART(>=)
NEVE_EACH_PART(==)
NEVE_EACH_PART(!=)
NEVE_EACH_PART(&)
NEVE_EACH_PART(|)
#undef NEVE_EACH_PART

template <class P, int K>
NEVE_INLINE Registers<P, K> operator-(const Registers<P, K>& a) {
  return each_part<K>([&](int k) NEVE_INLINE_LAMBDA { return -a.part[k]; });
}
template <class P, int K>
NEVE_INLINE Registers<P, K> operator~(const Registers<P, K>& a) {
  return each_part<K>([&](int k) NEVE_INLINE_LAMBDA { return ~a.part[k]; });
}
template <class P, int K, class B>
NEVE_INLINE Registers<P, K>& operator+=(Registers<P, K>& a, const B& b) {
  return a = a + b;
}
template <class P, int K, class B>
NEVE_INLINE Registers<P, K>& operator*=(Registers<P, K>& a, const B& b) {
  return a = a * b;
}

template <IsPack R>
NEVE_INLINE R splat(scalar_t<R> a) {
  return a - R{};
}

template <IsPack R, class M>
NEVE_INLINE R select(const M& mask, const R& yes, const R& no) {
  if constexpr (register_count<R> > 1) {
    return each_part<register_count<R>>(
        [&](int k) NEVE_INLINE_LAMBDA { return mask.part[k] ? yes.part[k] : no.part[k]; });
  } else {
    return mask ? yes : no;
  }
}

template <IsPack M>
NEVE_INLINE auto negated(const M& mask) {
  return ~mask;
}

template <IsPack M>
NEVE_INLINE bool any(const M& mask) {
  if constexpr (register_count<M> > 1) {
    auto all = mask.part[0];
    for_parts<register_count<M> - 1>([&](int k) NEVE_INLINE_LAMBDA { all |= mask.part[k + 1]; });
    return any(all);
  } else {
#if defined(__AVX512F__)
    if constexpr (sizeof(M) == 64) {
      const auto m = reinterpret_cast<__m512i>(mask);
      return _mm512_test_epi32_mask(m, m) != 0;
    }
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(M) == 32) {
      const auto m = reinterpret_cast<__m256i>(mask);
      return !_mm256_testz_si256(m, m);
    }
#endif
#if defined(__aarch64__)
    if constexpr (sizeof(M) == 16) return vmaxvq_u32(reinterpret_cast<uint32x4_t>(mask)) != 0;
#endif
    std::uint64_t words[sizeof(M) / 8], bits = 0;
    std::memcpy(words, &mask, sizeof(M));
    for (std::uint64_t w : words) bits |= w;
    return bits != 0;
  }
}

// One bit a lane, the first lane's the lowest.
template <IsPack M>
NEVE_INLINE std::uint32_t bits_of(const M& mask) {
#if defined(__AVX512F__)
  if constexpr (sizeof(M) == 64) {
    const auto m = reinterpret_cast<__m512i>(mask);
    return sizeof(scalar_t<M>) == 4 ? std::uint32_t(_mm512_test_epi32_mask(m, m))
                                    : std::uint32_t(_mm512_test_epi64_mask(m, m));
  }
#endif
  std::uint32_t bits = 0;
  for (int l = 0; l < width<M>; ++l) bits |= std::uint32_t(mask[l] != 0) << l;
  return bits;
}

// Call f(lane) for each lane of a mask, by rising lane.
template <IsPack M, class F>
NEVE_INLINE void for_lanes(const M& mask, F&& f) {
  for (std::uint32_t left = bits_of(mask); left != 0; left &= left - 1) f(__builtin_ctz(left));
}

template <IsPack R>
NEVE_INLINE scalar_t<R> max_lane(const R& a) {
  using T = scalar_t<R>;
  alignas(sizeof(R)) T v[width<R>];
  std::memcpy(v, &a, sizeof(R));
  for (int n = width<R> / 2; n > 0; n /= 2) {  // halves, so that the comparisons are packs
    for (int i = 0; i < n; ++i) v[i] = v[i + n] > v[i] ? v[i + n] : v[i];
  }
  return v[0];
}

// ---- memory ----

namespace detail {

// The numbers first, first + 1, first + 2, ... in the lanes of a register.
template <class P>
NEVE_INLINE P count_from(int first) {
  const P up = []<int... I>(std::integer_sequence<int, I...>) {
    return P{static_cast<scalar_t<P>>(I)...};
  }(std::make_integer_sequence<int, width<P>>{});
  return up + scalar_t<P>(first);
}

}  // namespace detail

// The mask of the first `count` lanes.
template <class R>
NEVE_INLINE auto first_lanes(int count) {
  using P = part_t<R>;
  return each_part<register_count<R>>(
      [&](int k) NEVE_INLINE_LAMBDA { return detail::count_from<P>(k * width<P>) < scalar_t<R>(count); });
}

namespace detail {

// A register anywhere in memory, which holds numbers of its kind and nothing else: addresses stay known beyond a store. (A
// memcpy would do, but GCC copies some by halves, which the next load waits for.)
template <class P>
struct Unaligned {
  typedef scalar_t<P> type __attribute__((vector_size(sizeof(P)), aligned(alignof(scalar_t<P>))));
};
template <class R>
NEVE_INLINE R load_registers(const scalar_t<R>* from) {
  using P = part_t<R>;
  return each_part<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA {
    return static_cast<P>(*reinterpret_cast<const typename Unaligned<P>::type*>(from + k * width<P>));
  });
}
template <class R>
NEVE_INLINE void store_registers(scalar_t<R>* to, const R& a) {
  using P = part_t<R>;
  for_parts<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA {
    *reinterpret_cast<typename Unaligned<P>::type*>(to + k * width<P>) = part_of(a, k);
  });
}

}  // namespace detail

namespace detail {

// The first `count` lanes of a register, from 0 to all of them; the lanes beyond stay zero, and what lies there is not
// read.
template <class P>
NEVE_INLINE P load_some(const scalar_t<P>* from, int count) {
  static_assert(sizeof(P) == register_bytes);
#if defined(__AVX512F__)
  const unsigned mask = (1u << count) - 1;
  if constexpr (std::is_same_v<P, Pack<float, 16>>) {
    return reinterpret_cast<P>(_mm512_maskz_loadu_ps(static_cast<__mmask16>(mask), from));
  } else {
    return reinterpret_cast<P>(_mm512_maskz_loadu_pd(static_cast<__mmask8>(mask), from));
  }
#elif defined(__AVX2__)
  const auto mask = reinterpret_cast<__m256i>(first_lanes<P>(count));
  if constexpr (std::is_same_v<P, Pack<float, 8>>) {
    return reinterpret_cast<P>(_mm256_maskload_ps(from, mask));
  } else {
    return reinterpret_cast<P>(_mm256_maskload_pd(from, mask));
  }
#else
  if (count == width<P>) return load_registers<P>(from);
  P r{};
  for_parts<width<P> - 1>([&](int k) NEVE_INLINE_LAMBDA {
    if (k < count) r[k] = from[k];
  });
  return r;
#endif
}

template <class P>
NEVE_INLINE void store_some(scalar_t<P>* to, const P& a, int count) {
#if defined(__AVX512F__)
  const unsigned mask = (1u << count) - 1;
  if constexpr (std::is_same_v<P, Pack<float, 16>>) {
    _mm512_mask_storeu_ps(to, static_cast<__mmask16>(mask), reinterpret_cast<__m512>(a));
  } else {
    _mm512_mask_storeu_pd(to, static_cast<__mmask8>(mask), reinterpret_cast<__m512d>(a));
  }
#elif defined(__AVX2__)
  const auto mask = reinterpret_cast<__m256i>(first_lanes<P>(count));
  if constexpr (std::is_same_v<P, Pack<float, 8>>) {
    _mm256_maskstore_ps(to, mask, reinterpret_cast<__m256>(a));
  } else {
    _mm256_maskstore_pd(to, mask, reinterpret_cast<__m256d>(a));
  }
#else
  if (count == width<P>) return store_registers(to, a);
  for_parts<width<P> - 1>([&](int k) NEVE_INLINE_LAMBDA {
    if (k < count) to[k] = a[k];
  });
#endif
}

}  // namespace detail

// Load `count` lanes; the lanes beyond stay zero, and what lies there is not read.
template <class R>
NEVE_INLINE R load(const scalar_t<R>* from, int count = width<R>) {
  using P = part_t<R>;
  if (count == width<R>) return detail::load_registers<R>(from);
  return each_part<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA {
    const int first = std::min(k * width<P>, count);
    return detail::load_some<P>(from + first, std::min(count - first, width<P>));
  });
}

// Store the first `count` lanes.
template <class R>
NEVE_INLINE void store(scalar_t<R>* to, const R& a, int count = width<R>) {
  using P = part_t<R>;
  if (count == width<R>) return detail::store_registers(to, a);
  for_parts<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA {
    const int first = std::min(k * width<P>, count);
    detail::store_some<P>(to + first, part_of(a, k), std::min(count - first, width<P>));
  });
}

// ---- sums ----

namespace detail {

template <class P, std::size_t... I>
NEVE_INLINE auto lower_half(P a, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, a, static_cast<int>(I)...);
}
template <class P, std::size_t... I>
NEVE_INLINE auto upper_half(P a, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, a, static_cast<int>(I + sizeof...(I))...);
}
template <class P>
NEVE_INLINE scalar_t<P> sum_of_register(P a) {
  constexpr int n = width<P>;
  if constexpr (n == 2) {
    return a[0] + a[1];
  } else {
    constexpr auto half = std::make_index_sequence<n / 2>{};
    return sum_of_register(static_cast<Pack<scalar_t<P>, n / 2>>(lower_half(a, half) + upper_half(a, half)));
  }
}

}  // namespace detail

// The sum of all lanes, by halves: the same bits whatever a register holds.
template <IsPack R>
NEVE_INLINE scalar_t<R> sum_lanes(const R& a) {
  if constexpr (register_count<R> > 1) {
    constexpr int half = register_count<R> / 2;
    return sum_lanes(each_part<half>([&](int k) NEVE_INLINE_LAMBDA { return a.part[k] + a.part[k + half]; }));
  } else {
    return detail::sum_of_register(a);
  }
}

}  // namespace neve
