// What boundaries and snow give each other in a step.
#pragma once

#include "coupling/contacts.hpp"
#include "cpu/fields.hpp"
#include "particles/solid_contact.hpp"
#include "sph/friction.hpp"
#include "sph/pressure.hpp"

namespace neve {

// Add what the boundaries gave particle p in a step of dt [s], by friction, pressure and shear, to the exchange with their
// solids: each force acts at the particle.
template <class T>
void record_walls(const CubicKernel<T>& kernel, const Model<T>& world, const SphState<T>& s,
                  const SphBoundary<T>& walls, const SphPairs<T>& boundary, const SphSums<T>& sums,
                  std::size_t p, double dt, ExchangeSum& exchange) {
  if (boundary.begin[p] == boundary.begin[p + 1]) return;
  const T V = sums.V.column(0)[p], pressure = sums.p.column(0)[p], m = s.m.column(0)[p];
  const Sym3<T> stress = symmetric_at(sums.s, p);
  const Mat3<T> L = matrix_at(sums.L, p);
  const T third = (stress.xx + stress.yy + stress.zz) * T(1.0 / 3);
  const Vec3<T> x = vector_at(s.x, p), rubbed = vector_at(s.v, p) + vector_at(sums.given, p) * T(dt);
  for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e) {
    const auto b = std::size_t(boundary.row[e]);
    const Solid<T>& solid = world.solids[std::size_t(walls.solid[b])];
    const Vec3<T> g{boundary.gradient[0][e], boundary.gradient[1][e], boundary.gradient[2][e]};
    const bool leaves = pressure < T(0) && solid.mode == ContactMode::separate;
    const T k_b = detail::rubbing(kernel, world, s, walls, boundary, p, e), V_b = walls.V.column(0)[b];
    const Vec3<T> v_b = vector_at(walls.v, b);
    const Vec3<T> force = (rubbed - v_b) * (m * k_b) -
                          g * (leaves ? T(0) : V * T(mirrored) * pressure * V_b) +
                          (L * g) * (V * V_b * third);
    Exchange& sum = exchange.of(solid.index);
    double J[3], arm[3];
    for (int k = 0; k < 3; ++k) {
      J[k] = dt * double(force[k]), arm[k] = double(x[k]) - double(solid.centre[k]);
      sum.impulse[k] -= J[k], sum.work += J[k] * double(v_b[k]);
    }
    for (int k = 0; k < 3; ++k)
      sum.moment[k] -= arm[(k + 1) % 3] * J[(k + 2) % 3] - arm[(k + 2) % 3] * J[(k + 1) % 3];
  }
}

// A ball around those points of a pack that count.
template <class T>
struct Ball {
  Vec3<T> centre{};
  T radius = -1;  // below zero: none counts
};
template <class R, class M>
inline Ball<scalar_t<R>> ball_around(const Vec3<R>& x, const M& mask) {
  using T = scalar_t<R>;
  if constexpr (is_pack<R>) {
    int first = 0, last = width<R> - 1;
    while (first < last && !mask[first]) ++first;
    while (last > first && !mask[last]) --last;
    if (!mask[first]) return {};
    Ball<T> ball;
    for (int k = 0; k < 3; ++k) ball.centre[k] = (x[k][first] + x[k][last]) / 2;
    const Vec3<R> off = x - spread<R>(ball.centre);
    ball.radius = std::sqrt(max_lane(select(mask, dot(off, off), R{}))) * T(1.0001);
    return ball;
  } else {
    return mask ? Ball<T>{x, T(0)} : Ball<T>{};
  }
}

namespace detail {

// A bound on the speed of a solid's surface within a ball [m/s].
template <class T>
T speed_near(const Solid<T>& solid, const Ball<T>& ball) {
  const auto length = [](const Vec3<T>& a) { return std::sqrt(dot(a, a)); };
  return length(solid.velocity) + length(solid.belt) +
         length(solid.omega) * (length(ball.centre - solid.centre) + ball.radius);
}

}  // namespace detail

// Let no particle pass the surface of a solid: the boundary particles lie below it, and snow that is too fast for their
// pressure meets it as in the discrete element method, as points. Changes v; `out` is how far solids set particles out [m].
template <class T>
void stay_outside(const Model<T>& world, const Vec3<Lanes<T>>& x, const Lanes<T>& m, const auto& here, T dt,
                  Vec3<Lanes<T>>& v, Vec3<Lanes<T>>& out, ExchangeSum& exchange) {
  using R = Lanes<T>;
  const R zero = splat<R>(0);
  out = {zero, zero, zero};
  if (world.solids.empty()) return;
  const Ball<T> ball = ball_around(x, here);
  if (ball.radius < T(0)) return;
  const T way = dt * std::sqrt(max_lane(select(here, R(dot(v, v)), zero)));
  for (const Solid<T>& solid : world.solids) {
    const T reach = ball.radius + T(2) * way + dt * detail::speed_near(solid, ball);
    if (!is_near(solid, ball.centre, reach)) continue;
    const auto contact = SolidContact<R>::at(solid, x, zero, here, here & (zero < zero), dt);
    const Vec3<R> before = v, v_co = solid.surface_velocity_at(x, contact.n);
    const auto met = contact.met(before, v_co);
    if (!any(met)) continue;
    v = contact.after(before, flat(contact.n), v_co);
    record(exchange.of(solid.index), met, m, contact.arm, v_co, before, v);
    const R depth = max(R(-surface(solid, x).phi), zero);
    out = out + contact.n * select(here, R(depth * T(set_out_of_bodies)), zero);
  }
}

}  // namespace neve
