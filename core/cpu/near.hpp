// Which solids a patch of nodes or of particles can meet, and which of its points may be near them.
#pragma once

#include <vector>

#include "coupling/contacts.hpp"
#include "cpu/grid/blocks.hpp"
#include "mpm/model.hpp"

namespace neve {

// The way to a node of a block from its first one [m].
template <class T>
Vec3<T> way_to_node(const Model<T>& model, int n) {
  const auto dx = static_cast<T>(model.dx);
  return {T(n / 16) * dx, T(n / 4 % 4) * dx, T(n % 4) * dx};
}

// Half so many cells along each axis from the first node of a block [m].
template <class T>
Vec3<T> middle_of(const Model<T>& model, BlockCoord at, double half) {
  const Vec3<double> first = first_node(model.dx, at);
  return {T(first.x + half * model.dx), T(first.y + half * model.dx), T(first.z + half * model.dx)};
}

// A solid near a cubic patch: in its frame, whose origin is the first node of the patch's block. So places are exact far from the
// world's origin, too. Most points of the patch are farther from a mesh than it matters: a few comparisons tell so,
// where samples would be read for each of them.
//
// The distance changes by no more than the way between two points. It is known from below at the middle of the patch, and at
// those of its eighths, where it is looked up when it is first asked for: by the thread whose patch it is.
template <class T>
struct NearSolid : Solid<T> {
  Vec3<T> middle;
  T step;         // from there to the middles of the eighths, along each axis [m]
  T far2, slow2;  // what is nearer to the middle and no faster does not get to it in this step [m2], [m2/s2]
  mutable bool looked = false;
  mutable T least_eighth[8] = {};  // phi at these is no less, x slowest [m]

  void look_around() const {
    for (int i = 0; i < 8; ++i) {
      const Vec3<T> to{i & 4 ? step : -step, i & 2 ? step : -step, i & 1 ? step : -step};
      least_eighth[i] = T(this->mesh->least(local_of(*this, middle + to)));
    }
    looked = true;
  }
};

// Those of the mask that may be within `reach` of the solid.
template <class R, class M>
inline auto may_reach(const NearSolid<scalar_t<R>>& solid, const Vec3<R>& x, const R& reach, const M& mask) {
  auto may = mask & mask;
  if (!solid.mesh) return may;
  if (!solid.looked) solid.look_around();
  const R step = splat<R>(solid.step);
  const Vec3<R> off = x - spread<R>(solid.middle),
                from{abs(off.x) - step, abs(off.y) - step, abs(off.z) - step};
  const auto each = [&](int i) { return splat<R>(solid.least_eighth[i]); };
  const auto by_z = [&](int i) { return select(off.z > R{}, each(i + 1), each(i)); };
  const auto by_y = [&](int i) { return select(off.y > R{}, by_z(i + 2), by_z(i)); };
  const R least = select(off.x > R{}, by_y(4), by_y(0));
  may = may & (least - sqrt(dot(from, from)) <= reach);
  if (any(may)) may = may & (least_at(solid, x, may) <= reach);
  return may;
}

// Whether none of the points of a mask that move along `path` [m/s] gets to the solid, at a glance.
template <class R, class M>
inline bool stays_away(const NearSolid<scalar_t<R>>& solid, const Vec3<R>& x, const Vec3<R>& path,
                       const M& mask) {
  if (!solid.mesh) return false;
  const Vec3<R> off = x - spread<R>(solid.middle);
  return !any(mask & ((dot(off, off) >= solid.far2) | (dot(path, path) >= solid.slow2)));
}

// Balls around the solids of a model, where they are now: which of them may be near a place is told of many at a time.
template <class T>
class SolidBalls {
  using R = Lanes<T>;

 public:
  explicit SolidBalls(const Model<T>& model) : count_(model.solids.size()) {
    for (auto* column : {&x_, &y_, &z_, &radius_}) column->resize((count_ + width<R>) / width<R> * width<R>);
    for (std::size_t i = 0; i < count_; ++i) {
      const Solid<T>& solid = model.solids[i];
      x_[i] = solid.centre.x, y_[i] = solid.centre.y, z_[i] = solid.centre.z;
      radius_[i] = std::min(ball_around(solid) * T(1.0001), T(endless));
    }
  }
  // Call f(i) for each solid i, rising, whose ball is within `reach` of x; for others it may be called, too.
  template <class F>
  void each_near(const Vec3<T>& x, T reach, F&& f) const {
    for (std::size_t first = 0; first < count_; first += width<R>) {
      const int count = int(std::min<std::size_t>(width<R>, count_ - first));
      const R dx = load<R>(x_.data() + first, count) - x.x, dy = load<R>(y_.data() + first, count) - x.y,
              dz = load<R>(z_.data() + first, count) - x.z;
      const R far = load<R>(radius_.data() + first, count) + reach;
      const auto near = first_lanes<R>(count) & negated(dx * dx + dy * dy + dz * dz > far * far);
      for_lanes(near, [&](int l) { f(first + std::size_t(l)); });
    }
  }

 private:
  static constexpr double endless = 1e15;  // [m]; its square is a number, too
  // The radius of a ball around the origin of a solid's frame that holds it [m].
  static T ball_around(const Solid<T>& solid) {
    if (!is_bounded(solid.kind)) return T(endless);
    if (!solid.mesh) return bounding_radius(solid.kind, solid.half);
    double r2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double most = std::max(std::abs(solid.mesh->low[k]), std::abs(solid.mesh->high[k]));
      r2 += most * most;
    }
    return T(std::sqrt(r2));
  }

  std::size_t count_;
  std::vector<T> x_, y_, z_, radius_;  // [m]; whole packs
};

// The solids whose surface may lie within `reach` [cells] of the point `half` [cells] from a block's first node along each
// axis, with what is known of the distance around it.
template <class T>
std::vector<NearSolid<T>> near_solids(const Model<T>& model, const SolidBalls<T>& balls, BlockCoord at,
                                      double half, double reach) {
  const auto dx = static_cast<T>(model.dx);
  const Vec3<double> first = first_node(model.dx, at);
  const Vec3<T> middle{T(half) * dx, T(half) * dx, T(half) * dx};
  std::vector<NearSolid<T>> near;
  balls.each_near(middle_of(model, at, half), T(reach) * dx, [&](std::size_t index) {
    NearSolid<T> solid{model.solids[index], middle, dx, T(0), T(0)};
    for (int k = 0; k < 3; ++k)
      solid.centre[k] = T(double(solid.centre[k]) + double(solid.centre_beyond[k]) - first[k]);
    const T least = solid.mesh ? std::max(T(solid.mesh->least(local_of(solid, middle))), T(0)) : T(0);
    if (solid.mesh ? least > T(reach) * dx : !is_near(solid, middle, T(reach) * dx)) return;
    solid.far2 = least * least;
    near.push_back(solid);
  });
  return near;
}

// The solids that nodes of a block may meet.
template <class T>
std::vector<NearSolid<T>> solids_near_block(const Model<T>& model, const SolidBalls<T>& balls,
                                            BlockCoord at) {
  constexpr double middle = 1.5, reach = 3.2;  // [cells]: half a block's diagonal, and the widest margin
  return near_solids(model, balls, at, middle, reach);
}

// The solids that particles of a home may meet in a step of dt [s].
template <class T, class Spline>
std::vector<NearSolid<T>> solids_near_home(const Model<T>& model, const SolidBalls<T>& balls, BlockCoord at,
                                           double dt) {
  constexpr double half = Spline::shift + Spline::reach / 2,
                   half_diagonal = 1.7321 * Spline::reach / 2;  // [cells]
  constexpr double way = 1.9, short_way = 0.5;  // [cells] in a step: the most, and what is usual
  const auto dx = static_cast<T>(model.dx);
  std::vector<NearSolid<T>> near = near_solids(model, balls, at, half, half_diagonal + way);
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
