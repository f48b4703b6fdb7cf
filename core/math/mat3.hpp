// Three-vectors and 3x3 matrices over any real type (a scalar or a lane pack).
#pragma once

#include "math/real.hpp"

namespace neve {

template <class R>
struct Vec3 {
  R x, y, z;
  R& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  const R& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  bool operator==(const Vec3&) const = default;
};

template <class R>
NEVE_INLINE Vec3<R> operator+(const Vec3<R>& a, const Vec3<R>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class R>
NEVE_INLINE Vec3<R> operator-(const Vec3<R>& a, const Vec3<R>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class R, class S>
NEVE_INLINE Vec3<R> operator*(const Vec3<R>& a, const S& s) {
  return {a.x * s, a.y * s, a.z * s};
}
// The same vector in every lane.
template <class R>
NEVE_INLINE Vec3<R> spread(const Vec3<scalar_t<R>>& a) {
  return {splat<R>(a.x), splat<R>(a.y), splat<R>(a.z)};
}
template <class R>
NEVE_INLINE R dot(const Vec3<R>& a, const Vec3<R>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class R>
NEVE_INLINE Vec3<R> cross(const Vec3<R>& a, const Vec3<R>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class R, class M>
NEVE_INLINE Vec3<R> select(const M& mask, const Vec3<R>& a, const Vec3<R>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

// Columns, because the SVD turns columns.
template <class R>
struct Mat3 {
  Vec3<R> c0, c1, c2;
  Vec3<R>& column(int j) { return j == 0 ? c0 : j == 1 ? c1 : c2; }
  const Vec3<R>& column(int j) const { return j == 0 ? c0 : j == 1 ? c1 : c2; }
  R& operator()(int i, int j) { return column(j)[i]; }
  const R& operator()(int i, int j) const { return column(j)[i]; }
  bool operator==(const Mat3&) const = default;
};

template <class R>
NEVE_INLINE Vec3<R> operator*(const Mat3<R>& a, const Vec3<R>& v) {
  return a.c0 * v.x + a.c1 * v.y + a.c2 * v.z;
}
template <class R>
NEVE_INLINE Mat3<R> operator*(const Mat3<R>& a, const Mat3<R>& b) {
  return {a * b.c0, a * b.c1, a * b.c2};
}
template <class R>
NEVE_INLINE Mat3<R> operator+(const Mat3<R>& a, const Mat3<R>& b) {
  return {a.c0 + b.c0, a.c1 + b.c1, a.c2 + b.c2};
}
template <class R, class S>
NEVE_INLINE Mat3<R> scaled(const Mat3<R>& a, const S& s) {
  return {a.c0 * s, a.c1 * s, a.c2 * s};
}
template <class R>
NEVE_INLINE Vec3<R> transposed_times(const Mat3<R>& a, const Vec3<R>& v) {
  return {dot(a.c0, v), dot(a.c1, v), dot(a.c2, v)};
}
template <class R, class M>
NEVE_INLINE Mat3<R> select(const M& mask, const Mat3<R>& a, const Mat3<R>& b) {
  return {select(mask, a.c0, b.c0), select(mask, a.c1, b.c1), select(mask, a.c2, b.c2)};
}
template <class R>
NEVE_INLINE Mat3<R> identity() {
  const R o = splat<R>(1), z = splat<R>(0);
  return {{o, z, z}, {z, o, z}, {z, z, o}};
}
template <class R>
NEVE_INLINE R determinant(const Mat3<R>& a) {
  return dot(a.c0, cross(a.c1, a.c2));
}

// A symmetric matrix: six numbers.
template <class R>
struct Sym3 {
  R xx, yy, zz, xy, xz, yz;
};
template <class R, class M>
NEVE_INLINE Sym3<R> select(const M& mask, const Sym3<R>& a, const Sym3<R>& b) {
  return {select(mask, a.xx, b.xx), select(mask, a.yy, b.yy), select(mask, a.zz, b.zz),
          select(mask, a.xy, b.xy), select(mask, a.xz, b.xz), select(mask, a.yz, b.yz)};
}
template <class R>
NEVE_INLINE Sym3<R> times(const Sym3<R>& s, const R& a) {
  return {s.xx * a, s.yy * a, s.zz * a, s.xy * a, s.xz * a, s.yz * a};
}
// isotropic I + s
template <class R>
NEVE_INLINE Sym3<R> operator+(const R& isotropic, const Sym3<R>& s) {
  return {isotropic + s.xx, isotropic + s.yy, isotropic + s.zz, s.xy, s.xz, s.yz};
}
template <class R>
NEVE_INLINE Mat3<R> full(const Sym3<R>& s) {
  return {{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}};
}

}  // namespace neve
