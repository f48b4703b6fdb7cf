// Accelerations by gravity and by the friction of boundaries (Gissler et al. 2020, equations 24 and 25).
#pragma once

#include "sph/body_friction.hpp"

namespace neve {

// mu_b of a boundary over the distance of particles, of a coefficient of friction of 1, and of one that snow sticks to [m/s]:
// our choice. With the distance in it, the drag on an area does not depend on how fine the snow is.
inline constexpr double rubbing_speed = 2, sticking_speed = 2000;

// mu_b [m2/s].
template <class T>
NEVE_INLINE T boundary_viscosity(const CubicKernel<T>& kernel, const Solid<T>& solid) {
  const T speed = solid.mode == ContactMode::sticky ? T(sticking_speed) : T(rubbing_speed) * solid.mu_c;
  return speed * kernel.h * T(0.5);
}

// The friction of a step.
template <class T>
struct SphFriction {
  std::vector<T> drag;   // of boundary entries: -mu_b V_b (x_ib . grad W_ib) / (|x_ib|^2 + 0.01 h^2) [1/s]
  std::vector<Twist> U;  // how the bodies move with gravity and this friction
  std::vector<Vec3<T>> omega;  // by solid: how it turns in this step [rad/s]

  // The velocity of the solid of boundary particle b at particle p itself, with that of its surface. With that at b snow would
  // rub on a solid that it turns with, and the moment of the friction, which acts at p, could drive a body.
  Vec3<T> beside(const SphState<T>& s, const SphBoundary<T>& walls, std::size_t b, std::size_t p) const {
    const Vec3<T> away = vector_at(s.x, p) - vector_at(walls.x, b);
    return vector_at(walls.v, b) + cross(omega[std::size_t(walls.solid[b])], away);
  }
};

namespace detail {

template <class T>
void find_drag(const CubicKernel<T>& kernel, const Model<T>& world, const SphState<T>& s,
               const SphBoundary<T>& walls, const SphPairs<T>& boundary, SphFriction<T>& friction) {
  friction.drag.resize(boundary.begin[s.count]);
  each_row(s.count, [&](std::size_t p) {
    for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e) {
      const auto b = std::size_t(boundary.row[e]);
      const Vec3<T> x = vector_at(s.x, p) - vector_at(walls.x, b);
      const bool wet = s.is_water(p);  // its gradients beside boundaries are not those of W
      const T viscosity = wet ? T(2 * s.water.viscosity / s.water.rho0)
                              : boundary_viscosity(kernel, world.solids[std::size_t(walls.solid[b])]);
      const T along = wet ? dot(x, x) * kernel.slope(dot(x, x)) : dot(x, boundary.slope_at(e));
      friction.drag[e] =
          -viscosity * walls.V.column(0)[b] * along / (dot(x, x) + T(0.01) * kernel.h * kernel.h);
    }
  });
}

// Let the boundary particles of bodies, and their solids, move with U.
template <class T>
void set_boundary_velocities(const Model<T>& world, SphBoundary<T>& walls, SphFriction<T>& friction) {
  friction.omega.clear();
  for (const Solid<T>& solid : world.solids) friction.omega.push_back(solid.omega);
  for (std::size_t i = 0; i < friction.U.size(); ++i)
    friction.omega[std::size_t(world.bodies.solids[i])] = angular<T>(friction.U[i].data());
  if (friction.U.empty()) return;
  each_row(walls.count, [&](std::size_t b) {
    const Solid<T>& solid = world.solids[std::size_t(walls.solid[b])];
    if (solid.body < 0) return;
    const double* U = friction.U[std::size_t(solid.body)].data();
    set_vector(walls.v, b, linear<T>(U) + cross(angular<T>(U), vector_at(walls.x, b) - solid.centre));
  });
}

}  // namespace detail

// With k_b as above, u_b the solids' velocities at the particle and v* = v + dt a_other, the implicit velocity is
// v' = (v* + dt sum_b k_b u_b) / (1 + dt sum_b k_b), and what is asked for is the acceleration to it:
// a_friction = (v' - v*) / dt. The bodies' velocities U are found with it, so that a body lighter than the snow that rubs on
// it is not thrown about. `given` becomes a_other + a_friction, `inflow` sum_b V_b v_b . grad W_ib with the bodies' U.
template <class T>
void find_given(const CubicKernel<T>& kernel, const Model<T>& world, const SphState<T>& s,
                SphBoundary<T>& walls, const SphPairs<T>& boundary, double dt, SphSums<T>& sums,
                SphFriction<T>& friction) {
  const T step = T(dt);
  detail::find_drag(kernel, world, s, walls, boundary, friction);
  friction.U = detail::BodyFriction<T>(world, s, walls, boundary, friction.drag, dt).velocities();
  detail::set_boundary_velocities(world, walls, friction);
  each_row(s.count, [&](std::size_t p) {
    T rate = 0, inflow = 0;
    Vec3<T> carried{};
    for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e) {
      const auto b = std::size_t(boundary.row[e]);
      const T k_b = friction.drag[e];
      rate += k_b, carried = carried + friction.beside(s, walls, b, p) * k_b;
      inflow += walls.V.column(0)[b] * dot(vector_at(walls.v, b), boundary.slope_at(e));
    }
    const Vec3<T> a_other = world.gravity, fallen = vector_at(s.v, p) + a_other * step;
    Vec3<T> given = a_other;
    if (rate != T(0)) {
      const Vec3<T> rubbed = (fallen + carried * step) * (T(1) / (T(1) + step * rate));
      given = given + (rubbed - fallen) * (T(1) / step);
    }
    set_vector(sums.given, p, given);
    sums.inflow.column(0)[p] = inflow;
  });
}

}  // namespace neve
