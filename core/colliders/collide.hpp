// What solids do to snow: at the nodes of the grid, and to particles on their way through a step.
#pragma once

#include <limits>
#include <vector>

#include "colliders/analytic.hpp"
#include "colliders/exchange.hpp"

namespace neve {

// A wall often lies exactly on a row of nodes; this share of a cell decides that it holds them, rather than rounding.
inline constexpr double skin_cells = 1e-4;

// Steps along a way close to a surface; solids must be thicker.
inline constexpr double stride_cells = 0.05;

// So far a particle inside a solid is moved towards its surface in one step.
inline constexpr double push_cells = 0.1;

// A ball around those points of a pack that count.
template <class T>
struct Ball {
  Vec3<T> centre{};
  T radius = -1;  // below zero: none counts
};
template <class R, class M>
inline Ball<scalar_t<R>> ball_around(const Vec3<R>& x, const M& mask) {
  using T = scalar_t<R>;
  int first = 0, last = width<R> - 1;
  while (first < last && !mask[first]) ++first;
  while (last > first && !mask[last]) --last;
  if (!mask[first]) return {};
  Ball<T> ball;
  for (int k = 0; k < 3; ++k) ball.centre[k] = (x[k][first] + x[k][last]) / 2;
  const Vec3<R> off = x - spread<R>(ball.centre);
  ball.radius = std::sqrt(max_lane(select(mask, dot(off, off), R{}))) * T(1.0001);
  return ball;
}

// The same if one of the solids is a mesh, whose distance costs more than looking whether any point may be near.
template <class R, class M>
inline Ball<scalar_t<R>> ball_for(const std::vector<Solid<scalar_t<R>>>& solids, const Vec3<R>& x,
                                  const M& mask) {
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
template <class R>
inline auto held(const std::vector<Solid<scalar_t<R>>>& solids, const Vec3<R>& x, scalar_t<R> skin) {
  R least = splat<R>(std::numeric_limits<scalar_t<R>>::max());
  for (const auto& solid : solids) least = min(least, surface(solid, x).phi);
  return least <= splat<R>(skin);
}

// Hand (solid, normal, which nodes) to `tell` for every solid, in the order of the scene, that holds some of the nodes at
// x with mass m (zero: no snow there). A solid holds what is no more than `skin` [m] and its own margin outside.
template <class R, class F>
inline void each_holding(const std::vector<Solid<scalar_t<R>>>& solids, const Vec3<R>& x, R m,
                         scalar_t<R> skin, F&& tell) {
  const auto here = m > R{};
  const auto ball = ball_for(solids, x, here);
  for (const auto& solid : solids) {
    const scalar_t<R> reach = skin + solid.margin;
    if (solid.mesh && is_clear(solid, ball, reach)) continue;
    const Surface<R> s = surface(solid, x);
    const auto inside = (s.phi <= splat<R>(reach)) & here;
    if (any(inside)) tell(solid, s.normal, inside);
  }
}

// The velocity of snow of nodes at x after every solid that holds x has acted on it. What masses m exchange with each
// goes into the ledger.
template <class R>
inline Vec3<R> collide(const std::vector<Solid<scalar_t<R>>>& solids, const Vec3<R>& x, Vec3<R> v,
                       scalar_t<R> skin, R m, Ledger& ledger) {
  each_holding(solids, x, m, skin, [&](const auto& solid, const Vec3<R>& normal, const auto& inside) {
    const Vec3<R> before = v, v_co = solid.velocity_at(x);
    v = select(inside, after_contact(v, normal, v_co, solid.mode, solid.mu_c), v);
    book(ledger.of(solid.index), inside, m, x - spread<R>(solid.centre), v_co, before, v);
  });
  return v;
}

// Where a straight way through a step first meets a solid.
template <class R>
struct Hit {
  R at;  // share of the step; above 1: nowhere
  Vec3<R> normal;
};

// Find where points at x, outside at distance s.phi, that move by `way` relative to the solid come as near as `skin`.
//
// Sphere tracing (Hart 1996): a step of phi never jumps over the surface, however thin the solid is. Close to it, where
// points slide along, steps are `stride` at least, and one that ends inside is cut back to the skin by false position.
// What has not arrived after the last step is taken to be there. Only lanes of `mask` count.
template <class R, class M>
inline Hit<R> trace(const Solid<scalar_t<R>>& solid, const Vec3<R>& x, const Surface<R>& s,
                    const Vec3<R>& way, scalar_t<R> skin, scalar_t<R> stride, const M& mask) {
  using T = scalar_t<R>;
  constexpr int most_steps = 16;
  const R one = splat<R>(1), half_skin = splat<R>(skin / 2), tiny = splat<R>(std::numeric_limits<T>::min());
  const R length = max(sqrt(dot(way, way)), tiny);
  Hit<R> hit{splat<R>(2), s.normal};
  R before = {}, phi = s.phi, at = min((phi - half_skin) / length, one);
  auto going = mask;
  for (int k = 0; k < most_steps && any(going); ++k) {
    const Surface<R> near = surface(solid, x + way * at);
    const auto arrives = going & (near.phi <= skin);
    const R share = clamp((phi - half_skin) / max(phi - near.phi, tiny), R{}, one);
    hit.at = select(arrives, before + (at - before) * share, hit.at);
    hit.normal = select(going, near.normal, hit.normal);
    going = going & (near.phi > skin) & (at < one);
    before = at, phi = near.phi;
    at = min(at + max(phi - half_skin, splat<R>(stride)) / length, one);
  }
  hit.at = select(going, before, hit.at);
  return hit;
}

// Let the solids act on particles that are at x and would move along `path` [m/s] for dt: on their velocities v and on
// the path. A particle that a solid holds at the start is met there, and brought towards the surface if it is
// inside; one that comes to a solid within the step is met where it comes, so that nothing passes through.
template <class R>
inline void follow(const std::vector<Solid<scalar_t<R>>>& solids, const Vec3<R>& x, Vec3<R>& v, Vec3<R>& path,
                   scalar_t<R> dt, scalar_t<R> dx, R m, Ledger* ledger) {
  using T = scalar_t<R>;
  const T skin = T(skin_cells) * dx;
  const auto here = m > R{};
  const auto ball = ball_for(solids, x, here);
  for (const auto& solid : solids) {
    const Vec3<R> way = (path - solid.velocity_at(x)) * dt;
    const R reach = sqrt(dot(way, way)) + skin;
    if (solid.mesh && is_clear(solid, ball, max_lane(select(here, reach, R{})))) continue;
    const Surface<R> s = surface(solid, x);
    const auto inside = (s.phi <= splat<R>(skin)) & here;
    const auto comes = (s.phi > splat<R>(skin)) & (s.phi < reach) & here;
    if (!any(inside | comes)) continue;
    Hit<R> hit{splat<R>(2), s.normal};
    if (any(comes)) hit = trace(solid, x, s, way, skin, T(stride_cells) * dx, comes);
    const auto met = inside | (hit.at <= splat<R>(1));
    if (!any(met)) continue;
    hit.at = select(inside, R{}, hit.at);
    const Vec3<R> place = x + way * select(met, hit.at, R{}), v_co = solid.velocity_at(place), before = v;
    v = select(met, after_contact(v, hit.normal, v_co, solid.mode, solid.mu_c), v);
    const Vec3<R> turned = after_contact(path, hit.normal, v_co, solid.mode, solid.mu_c);
    const Vec3<R> out =
        hit.normal * (select(inside, min(max(R(-s.phi), R{}), splat<R>(T(push_cells) * dx)), R{}) / dt);
    path = select(met, path * hit.at + turned * (splat<R>(1) - hit.at) + out, path);
    if (ledger) book(ledger->of(solid.index), met, m, place - spread<R>(solid.centre), v_co, before, v);
  }
}

}  // namespace neve
