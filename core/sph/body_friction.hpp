// The velocities of bodies with the friction of snow on them, found together with the snow's.
#pragma once

#include "coupling/body_solver.hpp"
#include "sph/pairs.hpp"

namespace neve::detail {

// The snow that rubs on bodies in a step of dt. Of a particle beside them, with k_B the sum of the drags over a body's
// boundary and u_B the body's velocity there,
//
//   (1 + dt sum k) v' = v* + dt sum_colliders k u + dt sum_B k_B u_B,   and body B gets the impulse m dt k_B (v' - u_B).
template <class T>
class BodyFriction {
 public:
  BodyFriction(const Model<T>& world, const SphState<T>& s, const SphBoundary<T>& walls,
               const SphPairs<T>& boundary, const std::vector<T>& drag, double dt)
      : world_(world), s_(s), walls_(walls), boundary_(boundary), drag_(drag), dt_(dt) {}

  // Of all bodies; none if there are no bodies.
  std::vector<Twist> velocities() {
    const CoupledBodies& bodies = world_.bodies;
    if (bodies.solids.empty()) return {};
    chunks_.resize((s_.count + chunk - 1) / chunk);
    each_index(chunks_.size(), [&](std::size_t c) {
      for (std::size_t p = c * chunk; p < std::min(s_.count, (c + 1) * chunk); ++p) add(p, chunks_[c]);
    });
    std::erase_if(chunks_, [](const Chunk& c) { return c.particles.empty(); });
    const auto respond = [&](const std::vector<Twist>& U) { return responses(U); };
    return BodyVelocitySolver(bodies, dt_).solve(whole_responses(respond));
  }

 private:
  static constexpr std::size_t chunk = 256;
  struct Rubbed {
    Vec3<double> base;   // the right side without the bodies
    double m, all;       // mass, 1 + dt sum k
    std::size_t by_end;  // after the last of its bodies
  };
  struct By {
    int body;
    double own;  // dt k_B
    Vec3<double> arm;
  };
  struct Chunk {
    std::vector<Rubbed> particles;
    std::vector<By> by;
  };
  using Part = std::vector<std::pair<std::size_t, BodyResponse>>;

  void add(std::size_t p, Chunk& to) const {
    const std::size_t first = to.by.size();
    Rubbed here{{}, double(s_.m.column(0)[p]), 1.0, 0};
    for (int k = 0; k < 3; ++k) here.base[k] = double(s_.v.column(k)[p]) + dt_ * double(world_.gravity[k]);
    const Vec3<T> x = vector_at(s_.x, p);
    for (std::uint32_t e = boundary_.begin[p]; e < boundary_.begin[p + 1]; ++e) {
      const auto b = std::size_t(boundary_.row[e]);
      const Solid<T>& solid = world_.solids[std::size_t(walls_.solid[b])];
      const double own = dt_ * double(drag_[e]);
      here.all += own;
      if (solid.body < 0) {
        const Vec3<T> u = vector_at(walls_.v, b) + cross(solid.omega, x - vector_at(walls_.x, b));
        for (int k = 0; k < 3; ++k) here.base[k] += own * double(u[k]);
        continue;
      }
      auto by = std::find_if(to.by.begin() + std::ptrdiff_t(first), to.by.end(),
                             [&](const By& one) { return one.body == solid.body; });
      if (by == to.by.end()) {
        const Vec3<T> arm = x - solid.centre;
        by = to.by.insert(by, {solid.body, 0.0, {double(arm.x), double(arm.y), double(arm.z)}});
      }
      by->own += own;
    }
    here.by_end = to.by.size();
    if (here.by_end > first) to.particles.push_back(here);
  }

  // Those of the snow to bodies that move with U; chunk by chunk, then in the order of the chunks, whatever the threads do.
  std::vector<BodyResponse> responses(const std::vector<Twist>& U) const {
    std::vector<Part> parts(chunks_.size());
    each_index(chunks_.size(), [&](std::size_t c) {
      std::size_t first = 0;
      for (const Rubbed& one : chunks_[c].particles) {
        respond(one, chunks_[c].by, first, U, parts[c]);
        first = one.by_end;
      }
    });
    std::vector<BodyResponse> total(U.size());
    for (const Part& part : parts) {
      for (const auto& [body, response] : part) total[body].add(response);
    }
    return total;
  }

  static void respond(const Rubbed& one, const std::vector<By>& all, std::size_t first,
                      const std::vector<Twist>& U, Part& part) {
    const auto velocity = [&](const By& by) {
      const double* u = U[std::size_t(by.body)].data();
      return linear<double>(u) + cross(angular<double>(u), by.arm);
    };
    Vec3<double> v = one.base;
    for (std::size_t i = first; i < one.by_end; ++i) v = v + velocity(all[i]) * all[i].own;
    v = v * (1 / one.all);
    for (std::size_t i = first; i < one.by_end; ++i) {
      const By& by = all[i];
      const double D = by.own * (1 - by.own / one.all);
      response_of(std::size_t(by.body), part)
          .add(one.m, by.arm, (velocity(by) - v) * by.own, scaled(identity<double>(), D));
    }
  }
  static BodyResponse& response_of(std::size_t body, Part& part) {
    for (auto& [known, response] : part) {
      if (known == body) return response;
    }
    return part.emplace_back(body, BodyResponse{}).second;
  }

  const Model<T>& world_;
  const SphState<T>& s_;
  const SphBoundary<T>& walls_;
  const SphPairs<T>& boundary_;
  const std::vector<T>& drag_;
  const double dt_;
  std::vector<Chunk> chunks_;
};

}  // namespace neve::detail
