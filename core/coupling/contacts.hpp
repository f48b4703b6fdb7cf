// What solids do to the snow of grid nodes. `solids` is any range of Solid<T>.
#pragma once

#include "coupling/solid.hpp"
#include "math/standard.hpp"

namespace neve {

// A wall often lies exactly on a row of nodes; this share of a cell decides that it holds them, rather than rounding.
inline constexpr double skin_cells = 1e-4;

// Those points of a mask that a solid may be within `reach` of. One point asks a sample of a mesh first; of a pack, who knows
// more of the solid can tell.
template <class R, class M>
inline auto may_reach(const Solid<scalar_t<R>>& solid, const Vec3<R>& x, const R& reach, const M& mask) {
  if constexpr (is_pack<R>) {
    return mask & mask;
  } else {
    return mask && (!solid.mesh || is_near(solid, x, reach));
  }
}

// Whether none of the points of a mask that move along `path` [m/s] gets to the solid, at a glance: who knows more of the
// solid can tell.
template <class R, class M>
inline bool stays_away(const Solid<scalar_t<R>>&, const Vec3<R>&, const Vec3<R>&, const M&) {
  return false;
}

// Which points with mass m some solid holds: no more than `skin` [m] outside.
template <class Solids, class R>
inline auto held_by_any(const Solids& solids, const Vec3<R>& x, R m, scalar_t<R> skin) {
  const auto here = m > R{};
  auto held = here & negated(here);
  for (const auto& solid : solids) {
    const auto near = may_reach(solid, x, splat<R>(skin), here);
    if (any(near)) held = held | (near & (surface(solid, x, near).phi <= splat<R>(skin)));
  }
  return held;
}

// Call visit(solid, normal, which nodes) for every solid, in the order of the scene, that holds some of the nodes at
// x with mass m (zero: no snow there). A solid holds what is no more than `skin` [m] and its own margin outside.
template <class Solids, class R, class F>
inline void each_holding(const Solids& solids, const Vec3<R>& x, R m, scalar_t<R> skin, F&& visit) {
  const auto here = m > R{};
  for (const auto& solid : solids) {
    const R reach = splat<R>(skin + solid.margin);
    const auto near = may_reach(solid, x, reach, here);
    if (!any(near)) continue;
    const Surface<R> s = surface(solid, x, near);
    const auto inside = (s.phi <= reach) & near;
    if (any(inside)) visit(solid, s.normal, inside);
  }
}

// How far snow has left surfaces with play, along their normals; and by how much it may, in steps of dt.
template <class R>
struct Lift {
  Vec3<R> s;             // [m]
  scalar_t<R> dt, most;  // [s], [m]

  R along(const Vec3<R>& n) const { return clamp(dot(s, n), R{}, splat<R>(most)); }
  Play<R> play(const Vec3<R>& n) const {
    const R left = along(n);
    return {-left / splat<R>(dt), (splat<R>(most) - left) / splat<R>(dt)};
  }
  // Snow of the lanes `inside` goes on with v_n.
  template <class M>
  void follow(const M& inside, const Vec3<R>& n, const R& v_n) {
    const R now = clamp(R(along(n) + v_n * dt), R{}, splat<R>(most));
    s = s + n * select(inside, R(now - dot(s, n)), R{});
  }
};
// No surface has any.
struct NoLift {};

// The velocity of snow after a solid has acted on the lanes `inside`.
template <class R, class M>
inline Vec3<R> meet(const Solid<scalar_t<R>>& solid, const M& inside, const Facing<R>& facing,
                    const Vec3<R>& v_co, const Vec3<R>& v, NoLift&) {
  return select(inside, after_contact(v, facing, v_co, solid.mode, solid.mu_c), v);
}
template <class R, class M>
inline Vec3<R> meet(const Solid<scalar_t<R>>& solid, const M& inside, const Facing<R>& facing,
                    const Vec3<R>& v_co, const Vec3<R>& v, Lift<R>& lift) {
  NoLift none;
  if (!has_play(solid.mode, solid.mu_c)) return meet(solid, inside, facing, v_co, v, none);
  const Play<R> play = lift.play(facing.n);
  const Vec3<R> after = select(inside, after_contact(v, facing, v_co, solid.mode, solid.mu_c, play), v);
  lift.follow(inside, facing.n, dot(after - v_co, facing.mid) - facing.gained);
  return after;
}

// The velocity of snow of nodes at x after every solid that holds x has acted on it. Calls
// exchanged(solid, which nodes, arm from its centre, velocity of its surface, v before, v after) for each.
template <class Solids, class R, class L, class F>
inline Vec3<R> collide(const Solids& solids, const Vec3<R>& x, Vec3<R> v, L& lift, scalar_t<R> skin,
                       scalar_t<R> dt, R m, F&& exchanged) {
  each_holding(solids, x, m, skin, [&](const auto& solid, const Vec3<R>& normal, const auto& inside) {
    const Vec3<R> before = v, v_co = solid.surface_velocity_at(x, normal);
    v = meet(solid, inside, facing(solid, x, normal, before - v_co, splat<R>(dt), inside), v_co, v, lift);
    exchanged(solid, inside, x - spread<R>(solid.centre), v_co, before, v);
  });
  return v;
}

}  // namespace neve
