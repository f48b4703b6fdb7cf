// What a solid says of a point: how far its surface is, and which way is out.
#pragma once

#include "math/mat3.hpp"

namespace neve {

// Signed distance phi [m] (negative inside) and its gradient, the outward unit normal.
template <class R>
struct Surface {
  R phi;
  Vec3<R> normal;
};

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

// Two neighbouring quads of floats, in the precision of the question.
template <class T>
using Quads = Wide<T, 8>;
template <class T>
inline Quads<T> load_two_quads(const float* from) {
  using P = part_t<Quads<T>>;
  return each_part<register_count<Quads<T>>>([&](int k) NEVE_INLINE_LAMBDA {
    return __builtin_convertvector(load_registers<Pack<float, width<P>>>(from + k * width<P>), P);
  });
}

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
