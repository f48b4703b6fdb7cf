// Quads, the four numbers of a node or of a particle, and rows, the quads of four neighbouring nodes.
#pragma once

#include "math/compare.hpp"
#include "math/pack.hpp"

namespace neve {

// A product that sums which follow do not fuse with: needed more than once it is multiplied once, and processors add on other
// units than those that multiply.
template <IsPack P>
NEVE_INLINE P rounded(P a) {
  static_assert(register_count<P> == 1);
#if defined(__AVX512F__)
  asm("" : "+v"(a));
#elif defined(__SSE2__)
  asm("" : "+x"(a));
#elif defined(__aarch64__)
  asm("" : "+w"(a));
#endif
  return a;
}

namespace detail {
template <class R, int Start, std::size_t... I>
NEVE_INLINE R interleave_from(R a, R b, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, b, (Start + static_cast<int>(I) / 2 + (I % 2) * sizeof...(I))...);
}
template <class R, int Start, std::size_t... I>
NEVE_INLINE R pairs_from(R a, R b, std::index_sequence<I...>) {
  return __builtin_shufflevector(
      a, b,
      (Start + 2 * (static_cast<int>(I) / 4) + static_cast<int>(I) % 2 + ((I / 2) % 2) * sizeof...(I))...);
}
template <class R, int Start, std::size_t... I>
NEVE_INLINE R every_other(R a, R b, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, b, (Start + 2 * static_cast<int>(I))...);
}

// Registers of AVX2 are two halves, which few instructions cross: each half is transposed by itself.

// The transpose of four quads of double, one a register.
template <class P>
NEVE_INLINE void transpose(P (&q)[4]) {
  const P xz = __builtin_shufflevector(q[0], q[1], 0, 4, 2, 6),
          yw = __builtin_shufflevector(q[0], q[1], 1, 5, 3, 7);
  const P xz2 = __builtin_shufflevector(q[2], q[3], 0, 4, 2, 6),
          yw2 = __builtin_shufflevector(q[2], q[3], 1, 5, 3, 7);
  q[0] = __builtin_shufflevector(xz, xz2, 0, 1, 4, 5), q[2] = __builtin_shufflevector(xz, xz2, 2, 3, 6, 7);
  q[1] = __builtin_shufflevector(yw, yw2, 0, 1, 4, 5), q[3] = __builtin_shufflevector(yw, yw2, 2, 3, 6, 7);
}
// In each half of four registers of float the transpose of its four quads: columns become rows, or rows columns.
template <class P>
NEVE_INLINE void transpose_halves(P (&q)[4]) {
  const auto low = [](P a, P b) { return __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13); };
  const auto high = [](P a, P b) { return __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15); };
  const auto first = [](P a, P b) { return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13); };
  const auto last = [](P a, P b) { return __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15); };
  const P ab = low(q[0], q[1]), cd = low(q[2], q[3]), ab2 = high(q[0], q[1]), cd2 = high(q[2], q[3]);
  q[0] = first(ab, cd), q[1] = last(ab, cd), q[2] = first(ab2, cd2), q[3] = last(ab2, cd2);
}
// The lower halves of two registers, and the upper ones.
template <class P>
NEVE_INLINE P lower_halves(P a, P b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
}
template <class P>
NEVE_INLINE P upper_halves(P a, P b) {
  return __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}

template <class P>
NEVE_INLINE void store_quads_of_register(scalar_t<P>* out, P a, P b, P c, P d) {
  constexpr int n = width<P>;
  if constexpr (n == 4 && sizeof(P) == 32) {
    P q[4] = {a, b, c, d};
    transpose(q);
    for_parts<4>([&](int k) NEVE_INLINE_LAMBDA { store(out + 4 * k, q[k]); });
    return;
  } else if constexpr (n == 8 && sizeof(P) == 32) {
    P q[4] = {a, b, c, d};  // then quads 0 and 4, 1 and 5, ...
    transpose_halves(q);
    store(out, lower_halves(q[0], q[1])), store(out + 8, lower_halves(q[2], q[3]));
    store(out + 16, upper_halves(q[0], q[1])), store(out + 24, upper_halves(q[2], q[3]));
    return;
  }
  constexpr auto seq = std::make_index_sequence<n>{};
  const P ab0 = interleave_from<P, 0>(a, b, seq), ab1 = interleave_from<P, n / 2>(a, b, seq);
  const P cd0 = interleave_from<P, 0>(c, d, seq), cd1 = interleave_from<P, n / 2>(c, d, seq);
  if constexpr (n == 2) {
    store(out, ab0), store(out + 2, cd0), store(out + 4, ab1), store(out + 6, cd1);
  } else {
    store(out, pairs_from<P, 0>(ab0, cd0, seq));
    store(out + n, pairs_from<P, n / 2>(ab0, cd0, seq));
    store(out + 2 * n, pairs_from<P, 0>(ab1, cd1, seq));
    store(out + 3 * n, pairs_from<P, n / 2>(ab1, cd1, seq));
  }
}

template <class P>
NEVE_INLINE void load_quads_of_register(const scalar_t<P>* in, P& a, P& b, P& c, P& d) {
  constexpr int n = width<P>;
  constexpr auto seq = std::make_index_sequence<n>{};
  const P p0 = load<P>(in), p1 = load<P>(in + n), p2 = load<P>(in + 2 * n), p3 = load<P>(in + 3 * n);
  if constexpr (n == 4 && sizeof(P) == 32) {
    P q[4] = {p0, p1, p2, p3};
    transpose(q);
    a = q[0], b = q[1], c = q[2], d = q[3];
  } else if constexpr (n == 8 && sizeof(P) == 32) {
    P q[4] = {lower_halves(p0, p2), upper_halves(p0, p2), lower_halves(p1, p3), upper_halves(p1, p3)};
    transpose_halves(q);
    a = q[0], b = q[1], c = q[2], d = q[3];
  } else if constexpr (n == 2) {
    a = every_other<P, 0>(p0, p2, seq), b = every_other<P, 1>(p0, p2, seq);
    c = every_other<P, 0>(p1, p3, seq), d = every_other<P, 1>(p1, p3, seq);
  } else {
    const P ac0 = every_other<P, 0>(p0, p1, seq), bd0 = every_other<P, 1>(p0, p1, seq);
    const P ac1 = every_other<P, 0>(p2, p3, seq), bd1 = every_other<P, 1>(p2, p3, seq);
    a = every_other<P, 0>(ac0, ac1, seq), c = every_other<P, 1>(ac0, ac1, seq);
    b = every_other<P, 0>(bd0, bd1, seq), d = every_other<P, 1>(bd0, bd1, seq);
  }
}

}  // namespace detail

// Write four packs as an array of `width` quads: out[4 l + k] = k-th pack's lane l.
template <class R>
NEVE_INLINE void store_quads(scalar_t<R>* out, const R& a, const R& b, const R& c, const R& d) {
  for_parts<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA {
    detail::store_quads_of_register(out + k * 4 * width<part_t<R>>, part_of(a, k), part_of(b, k),
                                    part_of(c, k), part_of(d, k));
  });
}

// Read back what store_quads wrote.
template <class R>
NEVE_INLINE void load_quads(const scalar_t<R>* in, R& a, R& b, R& c, R& d) {
  if constexpr (register_count<R> == 1) {
    detail::load_quads_of_register(in, a, b, c, d);
  } else {
    for_parts<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA {
      detail::load_quads_of_register(in + k * 4 * width<part_t<R>>, a.part[k], b.part[k], c.part[k],
                                     d.part[k]);
    });
  }
}

// ---- rows ----

template <class T>
using Row = Wide<T, 16>;

namespace detail {

// The registers of a row: how many, and how many numbers and quads each has (half a quad: 0).
template <class T>
struct RowShape {
  static constexpr int lanes = register_lanes<T>, parts = 16 / lanes, quads = lanes / 4;
};

template <class T, class F>
NEVE_INLINE Row<T> row_of_parts(F&& f) {
  return each_part<RowShape<T>::parts>(f);
}

// A quad at each place of a register.
template <class T>
NEVE_INLINE Register<T> repeated_quad(const T* q) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<T, float>) {
    return reinterpret_cast<Register<T>>(_mm512_broadcast_f32x4(_mm_loadu_ps(q)));
  } else {
    return reinterpret_cast<Register<T>>(_mm512_broadcast_f64x4(_mm256_loadu_pd(q)));
  }
#elif defined(__AVX2__)
  if constexpr (std::is_same_v<T, float>) {
    return reinterpret_cast<Register<T>>(_mm256_broadcast_ps(reinterpret_cast<const __m128*>(q)));
  }
#endif
  return load<Register<T>>(q);
}

// Turn a register by half of its lanes.
template <class R, std::size_t... I>
NEVE_INLINE R half_turn(R a, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, a, ((I + sizeof...(I) / 2) % sizeof...(I))...);
}
// The lower (Upper: the upper) half of a, then that of b.
template <bool Upper, class R, std::size_t... I>
NEVE_INLINE R halves(R a, R b, std::index_sequence<I...>) {
  constexpr std::size_t n = sizeof...(I), first = Upper ? n / 2 : 0;
  return __builtin_shufflevector(a, b, (first + I % (n / 2) + (I < n / 2 ? 0 : n))...);
}
// In each quad of the register the number k of it.
template <int K, class R, std::size_t... I>
NEVE_INLINE R spread_in_quads(R a, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, a, (I / 4 * 4 + K)...);
}
// The number First + i / 4 of a register for its lane i: weights, each for a quad.
template <int First, class R, std::size_t... I>
NEVE_INLINE R one_for_each_quad(R a, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, a, (First + I / 4)...);
}

// Two of four weights, the first two or the last, each for a quad of a register of two.
template <class T>
NEVE_INLINE Register<T> two_weights(const T* w, int part) {
#if defined(__AVX2__) && !defined(__AVX512F__)
  if constexpr (std::is_same_v<T, float>) {  // within halves of the register, where GCC crosses them
    const __m256i from =
        part == 0 ? _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1) : _mm256_setr_epi32(2, 2, 2, 2, 3, 3, 3, 3);
    return reinterpret_cast<Register<T>>(
        _mm256_permutevar_ps(reinterpret_cast<__m256>(repeated_quad(w)), from));
  }
#endif
  constexpr auto seq = std::make_index_sequence<RowShape<T>::lanes>{};
  const Register<T> all = repeated_quad(w);
  return part == 0 ? one_for_each_quad<0>(all, seq) : one_for_each_quad<2>(all, seq);
}

}  // namespace detail

// Of a row the register `part`: a quad at each of its nodes.
template <class T>
NEVE_INLINE Register<T> part_of_quads(const T* q, int part) {
  if constexpr (detail::RowShape<T>::quads == 0) {
    return load<Register<T>>(q + part % 2 * 2);
  } else {
    return detail::repeated_quad(q);
  }
}

// Of a row the register `part`: four weights, each in all four numbers of its node.
template <class T>
NEVE_INLINE Register<T> part_of_weights(const T* w, int part) {
  using S = detail::RowShape<T>;
  constexpr auto seq = std::make_index_sequence<S::lanes>{};
  if constexpr (S::quads == 0) {
    return splat<Register<T>>(w[part / 2]);
  } else if constexpr (S::quads == 1) {
    return splat<Register<T>>(w[part]);
  } else if constexpr (S::quads == 4) {
    return detail::one_for_each_quad<0>(detail::repeated_quad(w), seq);
  } else {
    return detail::two_weights(w, part);
  }
}

// A quad at each of the four nodes.
template <class T>
NEVE_INLINE Row<T> row_of_quad(const T* q) {
  return detail::row_of_parts<T>([&](int k) NEVE_INLINE_LAMBDA { return part_of_quads(q, k); });
}

// Four weights, each in all four numbers of its node.
template <class T>
NEVE_INLINE Row<T> row_of_weights(const T* w) {
  return detail::row_of_parts<T>([&](int k) NEVE_INLINE_LAMBDA { return part_of_weights(w, k); });
}

// The last number of each node, in all four of its numbers.
template <class T>
NEVE_INLINE Row<T> last_of_quads(const Row<T>& a) {
  using S = detail::RowShape<T>;
  return detail::row_of_parts<T>([&](int k) NEVE_INLINE_LAMBDA {
    if constexpr (S::quads == 0) {
      return splat<Register<T>>(a.part[k | 1][1]);
    } else {
      return detail::spread_in_quads<3>(part_of(a, k), std::make_index_sequence<S::lanes>{});
    }
  });
}

// The maximum over the four nodes, at each of them.
template <class T>
NEVE_INLINE Row<T> max_of_nodes(const Row<T>& a) {
  using S = detail::RowShape<T>;
  constexpr auto seq = std::make_index_sequence<S::lanes>{};
  if constexpr (S::quads == 4) {
    const Register<T> m = max(a, detail::half_turn(a, seq));
    return max(m, __builtin_shufflevector(m, m, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3));
  } else if constexpr (S::quads == 2) {
    const Register<T> m = max(a.part[0], a.part[1]), all = max(m, detail::half_turn(m, seq));
    return {all, all};
  } else {
    constexpr int step = S::parts / 4;  // registers of a node
    return detail::row_of_parts<T>([&](int k) NEVE_INLINE_LAMBDA {
      const int j = k % step;
      return max(max(a.part[j], a.part[j + step]), max(a.part[j + 2 * step], a.part[j + 3 * step]));
    });
  }
}

// Sum the four nodes of each of four rows: the result holds the sums of a, b, c, d as four quads. The order of the sum
// is the same for every width of register: (0 + 2) + (1 + 3).
template <class T>
NEVE_INLINE Row<T> sum_nodes(const Row<T>& a, const Row<T>& b, const Row<T>& c, const Row<T>& d) {
  using S = detail::RowShape<T>;
  constexpr auto seq = std::make_index_sequence<S::lanes>{};
  if constexpr (S::quads == 4) {
    const Row<T> ab = detail::halves<false>(a, b, seq) + detail::halves<true>(a, b, seq);
    const Row<T> cd = detail::halves<false>(c, d, seq) + detail::halves<true>(c, d, seq);
    return __builtin_shufflevector(ab, cd, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27) +
           __builtin_shufflevector(ab, cd, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31);
  } else if constexpr (S::quads == 2) {
    const auto pair = [&](const Row<T>& r) { return r.part[0] + r.part[1]; };
    const Register<T> sa = pair(a), sb = pair(b), sc = pair(c), sd = pair(d);
    return {detail::halves<false>(sa, sb, seq) + detail::halves<true>(sa, sb, seq),
            detail::halves<false>(sc, sd, seq) + detail::halves<true>(sc, sd, seq)};
  } else {
    constexpr int step = S::parts / 4;
    const Row<T>* rows[4] = {&a, &b, &c, &d};
    return detail::row_of_parts<T>([&](int k) NEVE_INLINE_LAMBDA {
      const Row<T>& r = *rows[k / step];
      const int j = k % step;
      return (r.part[j] + r.part[j + 2 * step]) + (r.part[j + step] + r.part[j + 3 * step]);
    });
  }
}

// The k-th quad of a row, into `to`.
template <class T>
NEVE_INLINE void store_quad(T* to, const Row<T>& a, int k) {
  std::memcpy(to, reinterpret_cast<const T*>(&a) + 4 * k, 4 * sizeof(T));
}

template <class T>
NEVE_INLINE Row<T> load_row(const T* from) {
  return detail::row_of_parts<T>(
      [&](int k) NEVE_INLINE_LAMBDA { return load<Register<T>>(from + k * register_lanes<T>); });
}
template <class T>
NEVE_INLINE void store_row(T* to, const Row<T>& a) {
  for_parts<detail::RowShape<T>::parts>(
      [&](int k) NEVE_INLINE_LAMBDA { store(to + k * register_lanes<T>, part_of(a, k)); });
}

}  // namespace neve
