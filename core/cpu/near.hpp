// Which solids a patch of nodes or of particles can meet, and which of its points may be near them.
#pragma once

#include <vector>

#include "cpu/grid/blocks.hpp"
#include "mpm/model.hpp"

namespace neve {

template <class T>
Vec3<T> node_position(const Model<T>& model, BlockCoord at, int i, int j, int k) {
  const auto dx = static_cast<T>(model.dx);
  return {T(4 * at.x + i) * dx, T(4 * at.y + j) * dx, T(4 * at.z + k) * dx};
}

// A solid near a cubic patch. Most points of the patch are farther from a mesh than it matters: a few comparisons tell so,
// where samples would be read for each of them.
//
// The distance changes by no more than the way between two points. It is known from below at the middle of the patch, and at
// those of its eighths.
template <class T>
struct NearSolid : Solid<T> {
  Vec3<T> middle;
  T step;             // from there to the middles of the eighths, along each axis [m]
  T least_eighth[8];  // phi at these is no less, x slowest [m]
  T far2,
      slow2;  // what is nearer to the middle and no faster does not get to the solid in this step [m2], [m2/s2]
};

// Those of the mask that may be within `reach` of the solid.
template <class R, class M>
inline auto may_reach(const NearSolid<scalar_t<R>>& solid, const Vec3<R>& x, const R& reach, const M& mask) {
  auto may = mask & mask;
  if (!solid.mesh) return may;
  const R step = splat<R>(solid.step);
  const Vec3<R> off = x - spread<R>(solid.middle),
                from{abs(off.x) - step, abs(off.y) - step, abs(off.z) - step};
  const auto each = [&](int i) { return splat<R>(solid.least_eighth[i]); };
  const auto by_z = [&](int i) { return select(off.z > R{}, each(i + 1), each(i)); };
  const auto by_y = [&](int i) { return select(off.y > R{}, by_z(i + 2), by_z(i)); };
  const R least = select(off.x > R{}, by_y(4), by_y(0));
  return may & (least - sqrt(dot(from, from)) <= reach);
}

// Whether none of the points of a mask that move along `path` [m/s] gets to the solid, at a glance.
template <class R, class M>
inline bool stays_away(const NearSolid<scalar_t<R>>& solid, const Vec3<R>& x, const Vec3<R>& path,
                       const M& mask) {
  if (!solid.mesh) return false;
  const Vec3<R> off = x - spread<R>(solid.middle);
  return !any(mask & ((dot(off, off) >= solid.far2) | (dot(path, path) >= solid.slow2)));
}

// The solids whose surface may lie within `reach` [cells] of the point `half` [cells] from a block's first node along each
// axis, with what is known of the distance around it.
template <class T>
std::vector<NearSolid<T>> near_solids(const Model<T>& model, BlockCoord at, double half, double reach) {
  const auto dx = static_cast<T>(model.dx);
  const Vec3<T> middle =
      node_position(model, at, 0, 0, 0) + Vec3<T>{T(half) * dx, T(half) * dx, T(half) * dx};
  std::vector<NearSolid<T>> near;
  for (const Solid<T>& solid : model.solids) {
    const auto least_at = [&](const Vec3<T>& x) { return solid.mesh->least(local_of(solid, x)); };
    const T least = solid.mesh ? T(least_at(middle)) : T(0);
    if (solid.mesh ? least > T(reach) * dx : !is_near(solid, middle, T(reach) * dx)) continue;
    NearSolid<T>& one = near.emplace_back(NearSolid<T>{solid, middle, dx, {}, T(0), T(0)});
    if (!solid.mesh) continue;
    one.far2 = std::max(least, T(0)) * std::max(least, T(0));
    for (int i = 0; i < 8; ++i) {
      const Vec3<T> to{i & 4 ? dx : -dx, i & 2 ? dx : -dx, i & 1 ? dx : -dx};
      one.least_eighth[i] = T(least_at(middle + to));
    }
  }
  return near;
}

// The solids that particles of a home may meet in a step of dt [s].
template <class T, class Spline>
std::vector<NearSolid<T>> solids_near_home(const Model<T>& model, BlockCoord at, double dt) {
  constexpr double half = Spline::shift + Spline::reach / 2,
                   half_diagonal = 1.7321 * Spline::reach / 2;  // [cells]
  constexpr double way = 1.9, short_way = 0.5;  // [cells] in a step: the most, and what is usual
  const auto dx = static_cast<T>(model.dx);
  std::vector<NearSolid<T>> near = near_solids(model, at, half, half_diagonal + way);
  for (NearSolid<T>& solid : near) {
    const Vec3<T> arm = solid.middle - solid.centre;
    const T turning = std::sqrt(dot(solid.omega, solid.omega)),
            speed = std::sqrt(dot(solid.velocity, solid.velocity)) +
                    turning * (std::sqrt(dot(arm, arm)) + T(half_diagonal) * dx);
    const T gap = std::max(std::sqrt(solid.far2) - T(short_way + skin_cells) * dx, T(0));
    const T slow = std::max(T(short_way) * dx / T(dt) - speed, T(0));
    solid.far2 = gap * gap, solid.slow2 = slow * slow;
  }
  return near;
}

// What solids are to water: nothing holds it to them, and they do not rub it.
template <class T>
std::vector<NearSolid<T>> smooth(std::vector<NearSolid<T>> solids) {
  for (NearSolid<T>& solid : solids) solid.mode = ContactMode::separate, solid.mu_c = T(0);
  return solids;
}

}  // namespace neve
