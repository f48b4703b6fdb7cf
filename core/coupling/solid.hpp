// Solids: shapes that move, and how snow meets them.
#pragma once

#include "coupling/contact_law.hpp"
#include "geometry/shapes.hpp"

namespace neve {

// A solid at one instant: a collider, scripted or at rest, or a body, moved by forces.
template <class T>
struct Solid : PlacedShape<T> {
  int index;  // in the scene's order
  ContactMode mode;
  T mu_c;
  Vec3<T> velocity;
  Vec3<T> omega;  // [rad/s]
  Vec3<T>
      belt{};  // velocity of the surface past the solid, as of a conveyor belt; zero unless its faces are flat [m/s]
  T margin{};  // how far outside nodes count as held: a solid thinner than a cell would slip between them [m]
  int body = -1;            // row among the bodies; below zero: a collider
  Vec3<T> centre_beyond{};  // what is to be added to the centre, less than its rounding [m]

  template <class R>
  Vec3<R> velocity_at(const Vec3<R>& x) const {
    return spread<R>(velocity) + cross(spread<R>(omega), x - spread<R>(this->centre));
  }
  // What the belt adds to that where the unit normal is n: its part along the face.
  template <class R>
  Vec3<R> belt_along(const Vec3<R>& n) const {
    const Vec3<R> u = spread<R>(belt);
    return u - n * dot(u, n);
  }
  // The velocity of the surface, which snow rubs on, where the unit normal is n.
  template <class R>
  Vec3<R> surface_velocity_at(const Vec3<R>& x, const Vec3<R>& n) const {
    return velocity_at(x) + belt_along(n);
  }
};

// Where a solid of unit normal n at x faces snow that moves along it with v_rel for dt. Across an edge, where the normal half
// a step on is another face's, n alone counts. Lanes that are not of the mask `wanted` mean nothing.
template <class R, class M>
inline Facing<R> facing(const Solid<scalar_t<R>>& solid, const Vec3<R>& x, const Vec3<R>& n,
                        const Vec3<R>& v_rel, const R& dt, const M& wanted) {
  if (solid.kind == Shape::plane || solid.kind == Shape::box || solid.mode == ContactMode::sticky)
    return flat(n);
  const R half = dt * scalar_t<R>(0.5), one = splat<R>(1);
  const Vec3<R> along = v_rel - n * dot(v_rel, n), w = spread<R>(solid.omega);
  const Vec3<R> normal = surface(solid, x + along * half, wanted).normal + cross(w, n) * half;
  const R turn = dot(normal, n);
  const auto same_face = turn > splat<R>(scalar_t<R>(0.9));
  const Vec3<R> mid = select(same_face, normal * (one / select(same_face, turn, one)), n);
  const Vec3<R> from_centre = v_rel + cross(w, x - spread<R>(solid.centre));
  return {n, mid, select(same_face, dot(cross(w, from_centre), mid) * half, R{})};
}

// How far outside a solid of this thickness [m] nodes must count as held, so that it holds a layer of them wherever it
// lies between the rows.
inline double margin_of(double thickness, double dx) { return thickness < dx ? 0.5 * (dx - thickness) : 0.0; }

}  // namespace neve
