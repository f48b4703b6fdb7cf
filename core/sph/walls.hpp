// What boundaries and snow give each other in a step.
#pragma once

#include "coupling/contacts.hpp"
#include "cpu/fields.hpp"
#include "particles/body_contacts.hpp"
#include "sph/friction.hpp"
#include "sph/phases.hpp"

namespace neve {

// Add what the boundaries gave particle p in a step of dt [s], by friction, pressure and shear, to the exchange with their
// solids: each force acts at the particle.
template <class T>
void record_walls(const Model<T>& world, const SphState<T>& s, const SphBoundary<T>& walls,
                  const SphPairs<T>& boundary, const SphFriction<T>& friction, const SphSums<T>& sums,
                  std::size_t p, double dt, ExchangeSum& exchange) {
  if (boundary.begin[p] == boundary.begin[p + 1]) return;
  const T V = sums.V.column(0)[p], pressure = sums.p.column(0)[p], m = s.m.column(0)[p];
  const Sym3<T> stress = symmetric_at(sums.s, p);
  const T third = (stress.xx + stress.yy + stress.zz) * T(1.0 / 3), pushed = V * mirrored_at(s, p) * pressure;
  const bool leaves =
      !(vector_at(sums.held, p) == vector_at(sums.walls, p));  // as the solve for shear has it
  const Vec3<T> x = vector_at(s.x, p), rubbed = vector_at(s.v, p) + vector_at(sums.given, p) * T(dt);
  for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e) {
    const auto b = std::size_t(boundary.row[e]);
    const Solid<T>& solid = world.solids[std::size_t(walls.solid[b])];
    const bool may_leave = solid.mode == ContactMode::separate;
    const T along = (may_leave && leaves ? T(0) : V * third) - (may_leave && pressure < T(0) ? T(0) : pushed);
    const Vec3<T> u_b = friction.beside(s, walls, b, p);
    const Vec3<T> force =
        (u_b - rubbed) * (m * friction.drag[e]) + boundary.slope_at(e) * (along * walls.V.column(0)[b]);
    Exchange& sum = exchange.of(solid.index);
    double J[3], arm[3];
    for (int k = 0; k < 3; ++k) {
      J[k] = dt * double(force[k]), arm[k] = double(x[k]) - double(solid.centre[k]);
      sum.impulse[k] -= J[k], sum.work += J[k] * double(u_b[k]);
    }
    for (int k = 0; k < 3; ++k)
      sum.moment[k] -= arm[(k + 1) % 3] * J[(k + 2) % 3] - arm[(k + 2) % 3] * J[(k + 1) % 3];
  }
}

namespace detail {

// A bound on the speed of a solid's surface within a ball [m/s].
template <class T>
T speed_near(const Solid<T>& solid, const Around<T>& ball) {
  const auto length = [](const Vec3<T>& a) { return std::sqrt(dot(a, a)); };
  return length(solid.velocity) + length(solid.belt) +
         length(solid.omega) * (length(ball.middle - solid.centre) + ball.radius);
}

}  // namespace detail

// Let no particle pass the surface of a solid: the boundary particles lie below it, and snow that is too fast for their
// pressure meets it as in the discrete element method, as points: colliders now, bodies once it is known how they move.
template <class T>
class PointContacts {
 public:
  using R = Lanes<T>;
  // size: half the distance of particles [m].
  PointContacts(const Model<T>& world, T size, T dt) : world_(world), size_(size), dt_(dt) {}

  // Let the colliders act on a pack, on which these forces [N] do, and say whether it may meet bodies: it then lies in `waiting`.
  bool act(ContactPack<T>& pack, const Vec3<R>& force, ExchangeSum& exchange,
           BodyContacts<T>& waiting) const {
    pack.begin = waiting.contacts.size();
    SolidContacts<R> colliders;
    const auto here = first_lanes<R>(pack.count);
    const R zero = splat<R>(0);
    const Around<T> ball = ball_around(pack.x, here);
    const T way = dt_ * std::sqrt(largest_lane(select(here, R(dot(pack.v, pack.v)), zero)));
    for (const Solid<T>& solid : world_.solids) {
      const T meets = T(2) * way + dt_ * detail::speed_near(solid, ball);
      if (!is_near(solid, ball.middle, ball.radius + meets)) continue;
      const auto contact =
          SolidContact<R>::at(solid, pack.x, zero, splat<R>(size_), here, here & (zero < zero), dt_);
      if (solid.body < 0) {
        colliders.contacts.push_back(contact);
      } else if (any(here & (contact.room * dt_ <= splat<R>(meets)))) {
        waiting.contacts.push_back(contact);
      }
    }
    pack.v = colliders.act(pack.v, dt_);
    for (std::size_t e = 0; e < colliders.contacts.size(); ++e) {
      const ContactChange<R>& change = colliders.changes[e];
      record(colliders.contacts[e], change.v_co, change.before, change.after, pack, force, exchange);
    }
    pack.end = waiting.contacts.size();
    if (pack.end == pack.begin) return false;
    waiting.packs.push_back(pack);
    return true;
  }

  // Let the bodies, which move with U, act on one that has waited.
  void finish(const BodyContacts<T>& waiting, ContactPack<T>& pack, const std::vector<Twist>& U,
              const Vec3<R>& force, ExchangeSum& exchange) const {
    pack.v = detail::touch_bodies(
        waiting, pack, U,
        [&](const auto& contact, const Vec3<R>& v_co, const Vec3<R>& before, const Vec3<R>& after) {
          record(contact, v_co, before, after, pack, force, exchange);
        });
  }

 private:
  static void record(const SolidContact<R>& contact, const Vec3<R>& v_co, const Vec3<R>& before,
                     const Vec3<R>& after, ContactPack<T>& pack, const Vec3<R>& force,
                     ExchangeSum& exchange) {
    const auto met = contact.met(before, v_co);
    if (any(met))
      pack.out = pack.out + record_contact(contact, met, pack.m, v_co, before, after, force, exchange);
  }

  const Model<T>& world_;
  const T size_, dt_;
};

// By how much the velocities of bodies change with what snow gave them in `exchanged`.
inline std::vector<Twist> changes(const CoupledBodies& bodies, const std::vector<Exchange>& exchanged) {
  std::vector<Twist> out(bodies.count());
  for (const BodyGroup& group : bodies.groups) {
    const std::size_t n = 6 * group.bodies.size();
    for (std::size_t row = 0; row < n; ++row) {
      double sum = 0;
      for (std::size_t c = 0; c < n; ++c) {
        const Exchange& given = exchanged[std::size_t(bodies.solids[group.bodies[c / 6]])];
        sum += group.mobility[row * n + c] * (c % 6 < 3 ? given.impulse[c % 6] : given.moment[c % 6 - 3]);
      }
      out[group.bodies[row / 6]][row % 6] = sum;
    }
  }
  return out;
}

// The bodies with velocities that have what snow gave them in `exchanged` already.
template <class T>
CoupledBodies pushed(const Model<T>& world, const std::vector<Exchange>& exchanged) {
  CoupledBodies bodies = world.bodies;
  const std::vector<Twist> more = changes(bodies, exchanged);
  for (std::size_t body = 0; body < more.size(); ++body) {
    for (std::size_t k = 0; k < 6; ++k) bodies.start[body][k] += more[body][k];
  }
  return bodies;
}

}  // namespace neve
