// Lane packs from rows of a column that are not neighbours, and sums over the lanes of a pack.
#pragma once

#include "math/real.hpp"

namespace neve {

namespace detail {

template <class P>
NEVE_INLINE P gather_register(const scalar_t<P>* from, const std::int32_t* rows) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<P, Pack<float, 16>>) {
    return reinterpret_cast<P>(_mm512_i32gather_ps(_mm512_loadu_si512(rows), from, 4));
  } else if constexpr (std::is_same_v<P, Pack<double, 8>>) {
    const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rows));
    return reinterpret_cast<P>(_mm512_i32gather_pd(at, from, 8));
  }
#elif defined(__AVX2__)
  if constexpr (std::is_same_v<P, Pack<float, 8>>) {
    const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rows));
    return reinterpret_cast<P>(_mm256_i32gather_ps(from, at, 4));
  } else if constexpr (std::is_same_v<P, Pack<double, 4>>) {
    const __m128i at = _mm_loadu_si128(reinterpret_cast<const __m128i*>(rows));
    return reinterpret_cast<P>(_mm256_i32gather_pd(from, at, 8));
  }
#endif
  alignas(sizeof(P)) scalar_t<P> v[width<P>];
  for (int l = 0; l < width<P>; ++l) v[l] = from[rows[l]];
  P out;
  std::memcpy(&out, v, sizeof(P));
  return out;
}

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

// from[rows[l]] in lane l; all `width` rows are read.
template <class R>
NEVE_INLINE R gather(const scalar_t<R>* from, const std::int32_t* rows) {
  using P = part_t<R>;
  return each_part<register_count<R>>(
      [&](int k) NEVE_INLINE_LAMBDA { return detail::gather_register<P>(from, rows + k * width<P>); });
}

// The sum of all lanes.
template <IsPack R>
NEVE_INLINE scalar_t<R> sum_lanes(const R& a) {
  auto all = part_of(a, 0);
  for_parts<register_count<R> - 1>([&](int k) NEVE_INLINE_LAMBDA { all = all + part_of(a, k + 1); });
  return detail::sum_of_register(all);
}

}  // namespace neve
