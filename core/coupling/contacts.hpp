// What solids do to the snow of grid nodes. `solids` is any range of Solid<T>.
#pragma once

#include "coupling/solid.hpp"
#include "math/standard.hpp"

namespace neve {

// A wall often lies exactly on a row of nodes; this share of a cell decides that it holds them, rather than rounding.
inline constexpr double skin_cells = 1e-4;

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

// The same if one of the solids is a mesh, whose distance costs more than looking whether any point may be near.
template <class Solids, class R, class M>
inline Ball<scalar_t<R>> ball_for(const Solids& solids, const Vec3<R>& x, const M& mask) {
  for (const auto& solid : solids) {
    if (solid.mesh) return ball_around(x, mask);
  }
  return {};
}

// Whether a mesh is farther than `reach` from all points in the ball: one look at its grid instead of one a lane.
template <class T>
inline bool is_clear(const Solid<T>& mesh, const Ball<T>& ball, T reach) {
  return ball.radius < 0 || !is_near(mesh, ball.centre, ball.radius + reach);
}

// Which points some solid holds: no more than `skin` [m] outside.
template <class Solids, class R>
inline auto held_by_any(const Solids& solids, const Vec3<R>& x, scalar_t<R> skin) {
  R least = splat<R>(std::numeric_limits<scalar_t<R>>::max());
  for (const auto& solid : solids) least = min(least, surface(solid, x).phi);
  return least <= splat<R>(skin);
}

// Call visit(solid, normal, which nodes) for every solid, in the order of the scene, that holds some of the nodes at
// x with mass m (zero: no snow there). A solid holds what is no more than `skin` [m] and its own margin outside.
template <class Solids, class R, class F>
inline void each_holding(const Solids& solids, const Vec3<R>& x, R m, scalar_t<R> skin, F&& visit) {
  const auto here = m > R{};
  const auto ball = ball_for(solids, x, here);
  for (const auto& solid : solids) {
    const scalar_t<R> reach = skin + solid.margin;
    if (solid.mesh && is_clear(solid, ball, reach)) continue;
    const Surface<R> s = surface(solid, x);
    const auto inside = (s.phi <= splat<R>(reach)) & here;
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
    v = meet(solid, inside, facing(solid, x, normal, before - v_co, splat<R>(dt)), v_co, v, lift);
    exchanged(solid, inside, x - spread<R>(solid.centre), v_co, before, v);
  });
  return v;
}

}  // namespace neve
