// What solids do to particles on their way through a step.
#pragma once

#include "coupling/contacts.hpp"

namespace neve {

// Steps along a way close to a surface; solids must be thicker.
inline constexpr double stride_cells = 0.05;

// So far a particle inside a solid is moved towards its surface in one step.
inline constexpr double push_cells = 0.1;

// Where a straight way through a step first meets a solid.
template <class R>
struct Impact {
  R at;  // share of the step; above 1: nowhere
  Vec3<R> normal;
};

// Find where points at x, outside at distance s.phi, that move by `way` relative to the solid come as near as `skin`.
//
// Sphere tracing (Hart 1996): a step of phi never jumps over the surface, however thin the solid is. Close to it, where
// points slide along, steps are `stride` at least, and one that ends inside is cut back to the skin by false position.
// What has not arrived after the last step is taken to be there. Only lanes of `mask` count.
template <class R, class M>
inline Impact<R> find_impact(const Solid<scalar_t<R>>& solid, const Vec3<R>& x, const Surface<R>& s,
                             const Vec3<R>& way, scalar_t<R> skin, scalar_t<R> stride, const M& mask) {
  using T = scalar_t<R>;
  constexpr int most_steps = 16;
  const R one = splat<R>(1), half_skin = splat<R>(skin / 2), tiny = splat<R>(std::numeric_limits<T>::min());
  const R length = max(sqrt(dot(way, way)), tiny);
  Impact<R> impact{splat<R>(2), s.normal};
  R before = {}, phi = s.phi, at = min((phi - half_skin) / length, one);
  auto going = mask;
  for (int k = 0; k < most_steps && any(going); ++k) {
    const Surface<R> near = surface(solid, x + way * at, going);
    const auto arrives = going & (near.phi <= skin);
    const R share = clamp((phi - half_skin) / max(phi - near.phi, tiny), R{}, one);
    impact.at = select(arrives, before + (at - before) * share, impact.at);
    impact.normal = select(going, near.normal, impact.normal);
    going = going & (near.phi > skin) & (at < one);
    before = at, phi = near.phi;
    at = min(at + max(phi - half_skin, splat<R>(stride)) / length, one);
  }
  impact.at = select(going, before, impact.at);
  return impact;
}

// Let the solids act on particles that are at x and would move along `path` [m/s] for dt: on their velocities v and on
// the path. A particle that a solid holds at the start is met there, and brought towards the surface if it is
// inside; one that comes to a solid within the step is met where it comes, so that nothing passes through. `exchanged` is called as by collide.
template <class Solids, class R, class F>
inline void move_past(const Solids& solids, const Vec3<R>& x, Vec3<R>& v, Vec3<R>& path, scalar_t<R> dt,
                      scalar_t<R> dx, R m, F&& exchanged) {
  using T = scalar_t<R>;
  const T skin = T(skin_cells) * dx;
  const auto here = m > R{};
  for (const auto& solid : solids) {
    if (stays_away(solid, x, path, here)) continue;
    const Vec3<R> way = (path - solid.velocity_at(x)) * dt;
    const R reach = sqrt(dot(way, way)) + skin;
    const auto near = may_reach(solid, x, reach, here);
    if (!any(near)) continue;
    const Surface<R> s = surface(solid, x, near);
    const auto inside = (s.phi <= splat<R>(skin)) & near;
    const auto comes = (s.phi > splat<R>(skin)) & (s.phi < reach) & near;
    if (!any(inside | comes)) continue;
    Impact<R> impact{splat<R>(2), s.normal};
    if (any(comes)) impact = find_impact(solid, x, s, way, skin, T(stride_cells) * dx, comes);
    const auto met = inside | (impact.at <= splat<R>(1));
    if (!any(met)) continue;
    impact.at = select(inside, R{}, impact.at);
    const Vec3<R> place = x + way * select(met, impact.at, R{}), before = v;
    const Vec3<R> v_co = solid.surface_velocity_at(place, impact.normal);
    // with play it is the nodes that hold snow back
    const ContactMode mode = has_play(solid.mode, solid.mu_c) ? ContactMode::separate : solid.mode;
    const Facing<R> there =
        facing(solid, place, impact.normal, path - v_co, R((splat<R>(1) - impact.at) * dt), met);
    v = select(met, after_contact(v, there, v_co, mode, solid.mu_c), v);
    const Vec3<R> turned = after_contact(path, there, v_co, mode, solid.mu_c);
    const Vec3<R> out =
        impact.normal * (select(inside, min(max(R(-s.phi), R{}), splat<R>(T(push_cells) * dx)), R{}) / dt);
    path = select(met, path * impact.at + turned * (splat<R>(1) - impact.at) + out, path);
    exchanged(solid, met, place - spread<R>(solid.centre), v_co, before, v);
  }
}

}  // namespace neve
