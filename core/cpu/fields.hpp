// Lane packs from and to the columns of a state: particles [p, p + count).
#pragma once

#include "math/mat3.hpp"
#include "mpm/state.hpp"

namespace neve {

// How many cache lines before their use columns are asked for, and how many particles share one. A step walks along some forty
// columns at once, more than the processor follows by itself; two lines ahead are too late for particles to grid, which takes
// less than half as long for one.
inline constexpr std::uint32_t lines_ahead = 5;
template <class T>
inline constexpr std::uint32_t line_particles = 64 / sizeof(T);

// Ask for the cache lines of columns that belong to the particle p and its pack, to be read or also written.
enum class Access { read, write };
template <Access A, class T>
NEVE_INLINE void prefetch(const Columns<T>& f, std::size_t p) {
  for (int k = 0; k < f.components(); ++k) __builtin_prefetch(f.column(k) + p, A == Access::write);
}
template <Access A, class T, int Components>
NEVE_INLINE void prefetch(const Field<T, Components>& f, std::size_t p) {
  const T* first = f.column(0) + p;
#pragma GCC unroll 9
  for (int k = 0; k < Components; ++k) __builtin_prefetch(first + k * f.stride(), A == Access::write);
}

template <class R>
NEVE_INLINE Vec3<R> load_vector(const Columns<scalar_t<R>>& f, std::size_t p, int count, int first = 0) {
  return {load<R>(f.column(first) + p, count), load<R>(f.column(first + 1) + p, count),
          load<R>(f.column(first + 2) + p, count)};
}
template <class R>
NEVE_INLINE void store_vector(Columns<scalar_t<R>>& f, std::size_t p, const Vec3<R>& a, int count,
                              int first = 0) {
  for (int k = 0; k < 3; ++k) store(f.column(first + k) + p, a[k], count);
}
template <class R>
NEVE_INLINE Mat3<R> load_matrix(const Field<scalar_t<R>, 9>& f, std::size_t p, int count) {
  Mat3<R> a;
  for (int k = 0; k < 9; ++k) a(k % 3, k / 3) = load<R>(f.column(k) + p, count);
  return a;
}
template <class R>
NEVE_INLINE void store_matrix(Field<scalar_t<R>, 9>& f, std::size_t p, const Mat3<R>& a, int count) {
  for (int k = 0; k < 9; ++k) store(f.column(k) + p, a(k % 3, k / 3), count);
}
template <class R>
NEVE_INLINE Sym3<R> load_symmetric(const Field<scalar_t<R>, 6>& f, std::size_t p, int count) {
  return {load<R>(f.column(0) + p, count), load<R>(f.column(1) + p, count), load<R>(f.column(2) + p, count),
          load<R>(f.column(3) + p, count), load<R>(f.column(4) + p, count), load<R>(f.column(5) + p, count)};
}
template <class R>
NEVE_INLINE void store_symmetric(Field<scalar_t<R>, 6>& f, std::size_t p, const Sym3<R>& a, int count) {
  const R* entry[6] = {&a.xx, &a.yy, &a.zz, &a.xy, &a.xz, &a.yz};
  for (int k = 0; k < 6; ++k) store(f.column(k) + p, *entry[k], count);
}

}  // namespace neve
