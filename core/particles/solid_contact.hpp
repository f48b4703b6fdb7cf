// Contact of particles with one solid (docs/particles.md).
#pragma once

#include "coupling/body_response.hpp"
#include "cpu/fields.hpp"
#include "neighbours/gather.hpp"

namespace neve {

// How fast a particle that lies inside a solid is set out of it: the share of the depth per step, of colliders and of
// bodies, and the most over half their distance. The work of setting out is force times way with the force before, so a way that
// grows or falls fast hides some; bodies, which lie less deep in snow, come to rest sooner by the larger share.
inline constexpr double set_out = 0.02, set_out_of_bodies = 0.1, most_out = 0.01;

// A ball.
template <class T>
struct Around {
  Vec3<T> middle{};
  T radius{};
};
// One around the lanes of `here`, of which the first is one.
template <class R>
Around<scalar_t<R>> ball_around(const Vec3<R>& x, const auto& here) {
  using T = scalar_t<R>;
  Vec3<T> low{}, high{};
  for (int k = 0; k < 3; ++k) {
    const R u = select(here, x[k], splat<R>(x[k][0]));
    low[k] = least_lane(u), high[k] = largest_lane(u);
  }
  const Vec3<T> half = (high - low) * T(0.5);
  return {low + half, std::sqrt(dot(half, half))};
}

// A pack of particles of radius r at one solid. A particle that would sink in moves to the surface in this step, with the
// laws of contact of the material point method; one that lies inside is set out, without a velocity.
template <class R>
struct SolidContact {
  using T = scalar_t<R>;
  using Mask = decltype(R{} < R{});
  const Solid<T>* solid;
  Mask here, held;    // which lanes count, and which of them touch the solid or lie inside
  Mask runs;          // which are water, which runs along any surface
  Vec3<R> x, n, arm;  // position [m], the solid's normal there, place from the solid's centre [m]
  R room;             // speed along -n with which a particle just arrives in this step [m/s]
  R out;              // how far particles that lie inside are set out in this step [m]

  // r: radius [m], 0 for points; size: half the distance of particles, by which the way out is bound [m].
  static SolidContact at(const Solid<T>& solid, const Vec3<R>& x, const R& r, const R& size, const Mask& here,
                         const Mask& runs, T dt) {
    const R zero = splat<R>(0);
    const Surface<R> surface = neve::surface(solid, x);
    const R gap = surface.phi - r;
    return {&solid,
            here,
            here & (gap <= T(0)),
            here & runs,
            x,
            surface.normal,
            x - spread<R>(solid.centre),
            R(max(gap, zero) * (T(1) / dt)),
            R(min(max(R(-gap), zero) * T(solid.body < 0 ? set_out : set_out_of_bodies), size * T(most_out)))};
  }
  // What snow that lies at the surface does there: friction with play would need a memory of how far it has left.
  ContactMode mode() const {
    return has_play(solid->mode, solid->mu_c) ? ContactMode::separate : solid->mode;
  }
  // The velocity less that with which a particle just arrives.
  Vec3<R> sped(const Vec3<R>& v) const { return v + n * room; }
  Mask met(const Vec3<R>& v, const Vec3<R>& v_co) const {
    return here & ((dot(sped(v) - v_co, n) < T(0)) | held);
  }
  // The velocity after contact at a surface that moves with v_co, of the lanes that meet it.
  Vec3<R> after(const Vec3<R>& v, const Facing<R>& facing, const Vec3<R>& v_co) const {
    const Vec3<R> u = sped(v);
    const Vec3<R> leaves = after_contact(u, facing, v_co, ContactMode::separate, solid->mu_c);
    const Vec3<R> holds = after_contact(u, facing, v_co, mode(), solid->mu_c);
    Vec3<R> then = select(held, holds, leaves);
    if (any(runs)) then = select(runs, after_contact(u, facing, v_co, ContactMode::separate, T(0)), then);
    return select(met(v, v_co), then - n * room, v);
  }
  // How far the solid sets particles out in this step [m].
  Vec3<R> way_out() const { return n * select(here, out, splat<R>(0)); }
};

// Record in `exchange` what a solid did to the lanes `met` of a pack, and the work of setting them out against the forces on
// them [N]. Returns the way out [m].
template <class R>
Vec3<R> record_contact(const SolidContact<R>& contact, const typename SolidContact<R>::Mask& met, const R& m,
                       const Vec3<R>& v_co, const Vec3<R>& before, const Vec3<R>& after, const Vec3<R>& force,
                       ExchangeSum& exchange) {
  Exchange& sum = exchange.of(contact.solid->index);
  record(sum, met, m, contact.arm, v_co, before, after);
  const Vec3<R> way = contact.way_out();
  R against = splat<R>(0);
  for (int k = 0; k < 3; ++k) against += force[k] * way[k];
  sum.work -= double(sum_lanes(select(met, against, splat<R>(0))));
  return way;
}

}  // namespace neve
