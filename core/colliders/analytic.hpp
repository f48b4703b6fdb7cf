// Solids with an exact signed distance: plane, box, sphere, cylinder, placed by a centre and a rotation.
#pragma once

#include <algorithm>

#include "colliders/contact.hpp"

namespace neve {

enum class Shape { plane, box, sphere, cylinder };

// A solid at one instant. The plane passes through `centre` and its normal is the local z axis; the cylinder's axis
// is local z. `half` holds half edge lengths (box), (radius, -, half height) (cylinder), (radius, -, -) (sphere).
template <class T>
struct Solid {
  Shape shape;
  Contact mode;
  T mu_c;
  Vec3<T> half;
  Vec3<T> centre;
  Mat3<T> rotation;  // local to world
  Vec3<T> velocity;
  Vec3<T> omega;  // [rad/s]

  Vec3<T> velocity_at(const Vec3<T>& x) const { return velocity + cross(omega, x - centre); }
};

// Signed distance phi [m] (negative inside) and its gradient, the outward unit normal.
template <class T>
struct Surface {
  T phi;
  Vec3<T> normal;
};

namespace detail {

template <class T>
inline Surface<T> sphere_surface(const Vec3<T>& x, T radius) {
  const T r = std::sqrt(dot(x, x));
  if (r == T(0)) return {-radius, {T(0), T(0), T(1)}};
  return {r - radius, x * (T(1) / r)};
}

template <class T>
inline Surface<T> box_surface(const Vec3<T>& x, const Vec3<T>& half) {
  Vec3<T> q, out, sign;
  int nearest = 0;
  for (int k = 0; k < 3; ++k) {
    sign[k] = x[k] < T(0) ? T(-1) : T(1);
    q[k] = std::abs(x[k]) - half[k];
    out[k] = std::max(q[k], T(0));
    if (q[k] > q[nearest]) nearest = k;
  }
  Vec3<T> n{T(0), T(0), T(0)};
  const T far = std::sqrt(dot(out, out));
  if (far == T(0)) {  // inside: the nearest face
    n[nearest] = sign[nearest];
    return {q[nearest], n};
  }
  for (int k = 0; k < 3; ++k) n[k] = sign[k] * out[k] / far;
  return {far, n};
}

template <class T>
inline Surface<T> cylinder_surface(const Vec3<T>& x, T radius, T half_height) {
  const T r = std::sqrt(x.x * x.x + x.y * x.y);
  const Vec3<T> radial = r > T(0) ? Vec3<T>{x.x / r, x.y / r, T(0)} : Vec3<T>{T(1), T(0), T(0)};
  const Vec3<T> axial{T(0), T(0), x.z < T(0) ? T(-1) : T(1)};
  const T side = r - radius, cap = std::abs(x.z) - half_height;
  if (side <= T(0) || cap <= T(0)) {
    return side > cap ? Surface<T>{side, radial} : Surface<T>{cap, axial};
  }
  const T far = std::sqrt(side * side + cap * cap);
  return {far, (radial * side + axial * cap) * (T(1) / far)};
}

}  // namespace detail

template <class T>
inline Surface<T> surface(const Solid<T>& solid, const Vec3<T>& x) {
  const Vec3<T> local = transposed_times(solid.rotation, x - solid.centre);
  Surface<T> s{};
  switch (solid.shape) {
    case Shape::plane: return {local.z, solid.rotation.c2};
    case Shape::sphere: s = detail::sphere_surface(local, solid.half.x); break;
    case Shape::box: s = detail::box_surface(local, solid.half); break;
    case Shape::cylinder: s = detail::cylinder_surface(local, solid.half.x, solid.half.z); break;
  }
  return {s.phi, solid.rotation * s.normal};
}

// The velocity of snow at x after every solid that holds x has acted on it, in the order of the scene.
template <class T, class Solids>
inline Vec3<T> collide(const Solids& solids, const Vec3<T>& x, Vec3<T> v) {
  for (const Solid<T>& solid : solids) {
    const Surface<T> s = surface(solid, x);
    if (s.phi <= T(0)) v = after_contact(v, s.normal, solid.velocity_at(x), solid.mode, solid.mu_c);
  }
  return v;
}

}  // namespace neve
