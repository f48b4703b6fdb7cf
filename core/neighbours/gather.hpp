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

}  // namespace detail

// from[rows[l]] in lane l; all `width` rows are read.
template <class R>
NEVE_INLINE R gather(const scalar_t<R>* from, const std::int32_t* rows) {
  using P = part_t<R>;
  return each_part<register_count<R>>(
      [&](int k) NEVE_INLINE_LAMBDA { return detail::gather_register<P>(from, rows + k * width<P>); });
}

// Four numbers of each row that lie together, as one register: faster than four gathers.
template <class T>
struct alignas(4 * sizeof(T)) Quartet {
  T a, b, c, d;
};
template <class R>
struct Quartets {
  R a, b, c, d;
};

// from[rows[l]] in lane l; all `width` rows are read.
template <class R>
NEVE_INLINE Quartets<R> gather_quartets(const Quartet<scalar_t<R>>* from, const std::int32_t* rows) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<R, Pack<float, 16>>) {
    const auto four = [&](int k) NEVE_INLINE_LAMBDA {  // rows k, k + 4, k + 8, k + 12
      const auto at = [&](int l) NEVE_INLINE_LAMBDA { return _mm_load_ps(&from[rows[l]].a); };
      __m512 out = _mm512_castps128_ps512(at(k));
      out = _mm512_mask_broadcast_f32x4(out, 0x00f0, at(k + 4));
      out = _mm512_mask_broadcast_f32x4(out, 0x0f00, at(k + 8));
      return _mm512_mask_broadcast_f32x4(out, 0xf000, at(k + 12));
    };
    const __m512 r0 = four(0), r1 = four(1), r2 = four(2), r3 = four(3);
    const __m512d ab0 = _mm512_castps_pd(_mm512_unpacklo_ps(r0, r1)),
                  ab2 = _mm512_castps_pd(_mm512_unpacklo_ps(r2, r3)),
                  cd0 = _mm512_castps_pd(_mm512_unpackhi_ps(r0, r1)),
                  cd2 = _mm512_castps_pd(_mm512_unpackhi_ps(r2, r3));
    return {
        reinterpret_cast<R>(_mm512_unpacklo_pd(ab0, ab2)), reinterpret_cast<R>(_mm512_unpackhi_pd(ab0, ab2)),
        reinterpret_cast<R>(_mm512_unpacklo_pd(cd0, cd2)), reinterpret_cast<R>(_mm512_unpackhi_pd(cd0, cd2))};
  }
#elif defined(__AVX2__)
  if constexpr (std::is_same_v<part_t<R>, Pack<float, 8>>) {
    Quartets<R> out;
    for_parts<register_count<R>>([&](int part) NEVE_INLINE_LAMBDA {
      const std::int32_t* eight = rows + 8 * part;
      const auto two = [&](int k) NEVE_INLINE_LAMBDA {  // rows k, k + 4
        return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(&from[eight[k]].a)),
                                    _mm_load_ps(&from[eight[k + 4]].a), 1);
      };
      const __m256 r0 = two(0), r1 = two(1), r2 = two(2), r3 = two(3);
      const __m256d ab0 = _mm256_castps_pd(_mm256_unpacklo_ps(r0, r1)),
                    ab2 = _mm256_castps_pd(_mm256_unpacklo_ps(r2, r3)),
                    cd0 = _mm256_castps_pd(_mm256_unpackhi_ps(r0, r1)),
                    cd2 = _mm256_castps_pd(_mm256_unpackhi_ps(r2, r3));
      const auto set = [&](R& to, __m256d its) NEVE_INLINE_LAMBDA {
        const auto whole = reinterpret_cast<part_t<R>>(its);
        if constexpr (register_count<R> == 1) {
          to = whole;
        } else {
          to.part[part] = whole;
        }
      };
      set(out.a, _mm256_unpacklo_pd(ab0, ab2)), set(out.b, _mm256_unpackhi_pd(ab0, ab2));
      set(out.c, _mm256_unpacklo_pd(cd0, cd2)), set(out.d, _mm256_unpackhi_pd(cd0, cd2));
    });
    return out;
  }
#endif
  alignas(64) scalar_t<R> v[4][width<R>];
  for (int l = 0; l < width<R>; ++l) {
    const Quartet<scalar_t<R>>& q = from[rows[l]];
    v[0][l] = q.a, v[1][l] = q.b, v[2][l] = q.c, v[3][l] = q.d;
  }
  return {load<R>(v[0], width<R>), load<R>(v[1], width<R>), load<R>(v[2], width<R>), load<R>(v[3], width<R>)};
}

// The smallest and the largest of all lanes.
template <IsPack R>
NEVE_INLINE scalar_t<R> least_lane(const R& a) {
  scalar_t<R> out = a[0];
  for (int l = 1; l < width<R>; ++l) out = a[l] < out ? a[l] : out;
  return out;
}
template <IsPack R>
NEVE_INLINE scalar_t<R> largest_lane(const R& a) {
  scalar_t<R> out = a[0];
  for (int l = 1; l < width<R>; ++l) out = a[l] > out ? a[l] : out;
  return out;
}

}  // namespace neve
