// Accelerations by gravity and by the friction of boundaries (Gissler et al. 2020, equations 24 and 25).
#pragma once

#include "sph/pairs.hpp"

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

namespace detail {

// mu_b V_b (x_ib . grad W_ib) / (|x_ib|^2 + 0.01 h^2) of entry e, lane l: below zero [1/s].
template <class T>
NEVE_INLINE T rubbing(const CubicKernel<T>& kernel, const Model<T>& world, const SphState<T>& s,
                      const SphBoundary<T>& walls, const SphPairs<T>& boundary, std::size_t p,
                      std::uint32_t e) {
  const auto b = std::size_t(boundary.row[e]);
  T along = 0, r2 = 0;
  for (int k = 0; k < 3; ++k) {
    const T x = s.x.column(k)[p] - walls.x.column(k)[b];
    along += x * boundary.gradient[k][e], r2 += x * x;
  }
  return boundary_viscosity(kernel, world.solids[std::size_t(walls.solid[b])]) * walls.V.column(0)[b] *
         along / (r2 + T(0.01) * kernel.h * kernel.h);
}

}  // namespace detail

// With k_b as above, the implicit velocity v' = (v + dt a_other - dt sum_b k_b v_b) / (1 - dt sum_b k_b), and what is asked
// for is the acceleration to it: a_friction = (v' - v - dt a_other) / dt. `given` becomes a_other + a_friction, `inflow`
// sum_b V_b v_b . grad W_ib.
template <class T>
void find_given(const CubicKernel<T>& kernel, const Model<T>& world, const SphState<T>& s,
                const SphBoundary<T>& walls, const SphPairs<T>& boundary, double dt, SphSums<T>& sums) {
  const T step = T(dt);
  each_row(s.count, [&](std::size_t p) {
    T rate = 0, inflow = 0;
    Vec3<T> carried{};
    for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e) {
      const auto b = std::size_t(boundary.row[e]);
      const T k_b = detail::rubbing(kernel, world, s, walls, boundary, p, e);
      const Vec3<T> v_b = vector_at(walls.v, b);
      rate += k_b, carried = carried + v_b * k_b;
      for (int k = 0; k < 3; ++k) inflow += walls.V.column(0)[b] * v_b[k] * boundary.gradient[k][e];
    }
    const Vec3<T> a_other = world.gravity, fallen = vector_at(s.v, p) + a_other * step;
    Vec3<T> given = a_other;
    if (rate != T(0)) {
      const Vec3<T> rubbed = (fallen - carried * step) * (T(1) / (T(1) - step * rate));
      given = given + (rubbed - fallen) * (T(1) / step);
    }
    set_vector(sums.given, p, given);
    sums.inflow.column(0)[p] = inflow;
  });
}

}  // namespace neve
