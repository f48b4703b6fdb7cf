// Bodies in water: their velocities are unknowns of the solve for pressure.
#pragma once

#include "sph/walls.hpp"

namespace neve::detail {

// What pressures do to bodies. G_iB is sum_b V_b grad W_ib over the boundary of body B, of water the gradient of what that fills
// (wet_walls.hpp). A particle at the pressure p_i pushes the body by k V_i p_i G_iB, where the particle is, k as `mirrored_at`:
// 1.5 of snow, whose tension pulls only at what it sticks to, 1 of water. What the body gives way is an inflow G_iB . u_B there.
template <class T>
class Floating {
 public:
  Floating(const Model<T>& world, const SphState<T>& s, const SphBoundary<T>& walls,
           const SphPairs<T>& boundary, double dt, const SphSums<T>& sums)
      : world_(world), dt_(dt), sums_(sums) {
    if (world.bodies.count() == 0) return;
    for (std::size_t p = 0; p < s.count; ++p) {
      const std::size_t first = touches_.size();
      for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e)
        add(s, walls, p, std::size_t(boundary.row[e]), boundary.slope_at(e), first);
    }
    inflow_.assign(s.count, T(0));
    stiffness_.assign(s.count, T(0));
    find_stiffness();
  }

  // The inflow at each particle by what the present pressures do to the bodies [1/s].
  void find_inflow() {
    if (touches_.empty()) return;
    std::vector<Exchange> pushes(world_.solids.size());
    for (const Touch& t : touches_) {
      const double pressure = double(sums_.p.column(0)[t.p]);
      const Vec3<T>& G = pressure < 0 ? t.holding : t.G;
      const double size = dt_ * double(t.mirror) * double(sums_.V.column(0)[t.p]) * pressure;
      Exchange& push = pushes[std::size_t(world_.bodies.solids[t.body])];
      for (int k = 0; k < 3; ++k) push.impulse[k] += size * double(G[k]);
      for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        push.moment[k] += size * (double(t.arm[a]) * double(G[b]) - double(t.arm[b]) * double(G[a]));
      }
    }
    const std::vector<Twist> U = changes(world_.bodies, pushes);
    for (const Touch& t : touches_) inflow_[t.p] = T(0);
    for (const Touch& t : touches_) {
      const double* u = U[t.body].data();
      inflow_[t.p] += dot(linear<T>(u) + cross(angular<T>(u), t.arm), t.G);
    }
  }
  T inflow(std::size_t p) const { return inflow_.empty() ? T(0) : inflow_[p]; }

  // At most how much the inflow at p changes with all pressures that touch its bodies [1/(Pa s)].
  T stiffness(std::size_t p) const { return stiffness_.empty() ? T(0) : stiffness_[p]; }

 private:
  struct Touch {
    std::size_t p, body;
    Vec3<T> G, holding;  // over all of its boundary, over what snow sticks to [1/m]
    Vec3<T> arm;         // from the body's centre [m]
    T mirror;            // how much of the pressure is mirrored at it [1]
  };

  void add(const SphState<T>& s, const SphBoundary<T>& walls, std::size_t p, std::size_t b,
           const Vec3<T>& slope, std::size_t first) {
    const Solid<T>& solid = world_.solids[std::size_t(walls.solid[b])];
    if (solid.body < 0) return;
    const auto body = std::size_t(solid.body);
    auto touch = std::find_if(touches_.begin() + std::ptrdiff_t(first), touches_.end(),
                              [&](const Touch& t) { return t.body == body; });
    if (touch == touches_.end())
      touch = touches_.insert(touch, {p, body, {}, {}, vector_at(s.x, p) - solid.centre, mirrored_at(s, p)});
    const Vec3<T> G = slope * walls.V.column(0)[b];
    touch->G = touch->G + G;
    if (solid.mode != ContactMode::separate) touch->holding = touch->holding + G;
  }

  void find_stiffness() {
    const std::vector<LargestMobility> most = largest_mobility(world_.bodies);
    const auto length = [](const Vec3<T>& a) { return std::sqrt(double(dot(a, a))); };
    std::vector<double> pushed(most.size()), turned(most.size());
    for (const Touch& t : touches_) {
      const double push = dt_ * double(t.mirror) * double(sums_.V.column(0)[t.p]) * length(t.G);
      pushed[t.body] += push, turned[t.body] += push * length(t.arm);
    }
    for (const Touch& t : touches_) {
      const double way =
          most[t.body].moves * pushed[t.body] + most[t.body].turns * turned[t.body] * length(t.arm);
      stiffness_[t.p] += T(length(t.G) * way);
    }
  }

  const Model<T>& world_;
  const double dt_;
  const SphSums<T>& sums_;
  std::vector<Touch> touches_;
  std::vector<T> inflow_, stiffness_;
};

}  // namespace neve::detail
