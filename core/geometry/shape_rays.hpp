// Where rays enter shapes with a formula, in the shape's own frame.
#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/shapes.hpp"

namespace neve {

// Where a ray enters a shape.
template <class T>
struct ShapeHit {
  T t = T(1e30);     // in lengths of the direction; that of a ray that misses
  Vec3<T> normal{};  // outward
};

namespace detail {

template <class T>
inline Vec3<T> unit_vector(const Vec3<T>& a) {
  return a * (T(1) / std::max(std::sqrt(dot(a, a)), T(1e-20)));
}

// Meet the slab |p| <= half on one axis: narrow [near, far], remember the axis entered last.
template <class T>
inline void clip_slab(T p, T d, T half, int axis, T& near, T& far, int& entered) {
  const T inv = T(1.0) / (std::abs(d) > T(1e-12) ? d : std::copysign(T(1e-12), d));
  const T a = (-half - p) * inv, b = (half - p) * inv;
  if (std::min(a, b) > near) {
    near = std::min(a, b);
    entered = axis;
  }
  far = std::min(far, std::max(a, b));
}

template <class T>
inline Vec3<T> axis_normal(int axis, Vec3<T> d) {
  return axis == 0   ? Vec3<T>{d.x > 0 ? -T(1.0) : T(1.0), 0, 0}
         : axis == 1 ? Vec3<T>{0, d.y > 0 ? -T(1.0) : T(1.0), 0}
                     : Vec3<T>{0, 0, d.z > 0 ? -T(1.0) : T(1.0)};
}

template <class T>
inline ShapeHit<T> enter_box(Vec3<T> half, Vec3<T> p, Vec3<T> d) {
  T near = 0, far = T(1e30);
  int axis = -1;
  clip_slab(p.x, d.x, half.x, 0, near, far, axis);
  clip_slab(p.y, d.y, half.y, 1, near, far, axis);
  clip_slab(p.z, d.z, half.z, 2, near, far, axis);
  if (axis < 0 || near >= far) return {};
  return {near, axis_normal(axis, d)};
}

template <class T>
inline ShapeHit<T> enter_sphere(T radius, Vec3<T> p, Vec3<T> d) {
  const T a = dot(d, d), b = dot(p, d), c = dot(p, p) - radius * radius;
  const T root = b * b - a * c;
  if (root <= 0) return {};
  const T t = (-b - std::sqrt(root)) / a;
  if (t <= 0) return {};
  return {t, unit_vector(p + d * t)};
}

template <class T>
inline ShapeHit<T> enter_cylinder(T radius, T half_height, Vec3<T> p, Vec3<T> d) {
  T near = 0, far = T(1e30);
  int axis = -1;
  clip_slab(p.z, d.z, half_height, 2, near, far, axis);
  const T a = d.x * d.x + d.y * d.y, b = p.x * d.x + p.y * d.y, c = p.x * p.x + p.y * p.y - radius * radius;
  const T root = b * b - a * c;
  if (a < T(1e-12) ? c > 0 : root <= 0) return {};
  if (a >= T(1e-12)) {
    const T from = (-b - std::sqrt(root)) / a;
    far = std::min(far, (-b + std::sqrt(root)) / a);
    if (from > near) {
      near = from;
      axis = 0;
    }
  }
  if (axis < 0 || near >= far) return {};
  const Vec3<T> q = p + d * near;
  return {near, axis == 2 ? axis_normal(2, d) : unit_vector(Vec3<T>{q.x, q.y, 0})};
}

}  // namespace detail

// Enter the shape from outside along a ray from p. The direction d need not have unit length.
template <class T>
inline ShapeHit<T> enter(Shape shape, const Vec3<T>& half, const Vec3<T>& p, const Vec3<T>& d) {
  switch (shape) {
    case Shape::box: return detail::enter_box(half, p, d);
    case Shape::sphere: return detail::enter_sphere(half.x, p, d);
    case Shape::cylinder: return detail::enter_cylinder(half.x, half.z, p, d);
    default: break;
  }
  if (p.z > 0 && d.z < 0) return {-p.z / d.z, {0, 0, 1}};
  return {};
}

}  // namespace neve
