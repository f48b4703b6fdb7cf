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
  T margin{};  // how far outside nodes count as held: a solid thinner than a cell would slip between them [m]
  int body = -1;  // row among the bodies; below zero: a collider

  template <class R>
  Vec3<R> velocity_at(const Vec3<R>& x) const {
    return spread<R>(velocity) + cross(spread<R>(omega), x - spread<R>(this->centre));
  }
};

// How far outside a solid of this thickness [m] nodes must count as held, so that it holds a layer of them wherever it
// lies between the rows.
inline double margin_of(double thickness, double dx) { return thickness < dx ? 0.5 * (dx - thickness) : 0.0; }

}  // namespace neve
