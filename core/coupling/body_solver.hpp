// The velocities of bodies after a step, found together with those of the snow that touches them.
//
// Snow that meets a body changes its momentum, and the body's velocity decides how the snow is changed. With U the
// velocities of the bodies (six per body), A their mobility, and P(U) the impulses of the snow on bodies that move
// with U, the velocities at the end are those with
//
//     U = U_0 + A P(U).
//
// To let the snow meet U_0 instead would throw a body that is lighter than the snow it touches to and fro. P falls
// with U (a body that flees is pushed less) and is smooth but for the kinks of contact and friction: Newton's
// method with the slope of the contact law, steps halved while the residual grows.
#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "coupling/block_contacts.hpp"
#include "coupling/body_response.hpp"
#include "coupling/coupled_bodies.hpp"
#include "math/dense.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

// What contact makes of a pack of nodes: velocities, and how far they have left surfaces with play [m].
template <class R>
struct Moved {
  Vec3<R> v, lift;
};

// Let the solids act, one after another, on a pack of nodes, and call visit(contact, v before, play, v_co, v after) for each. Bodies move with U.
template <class T, class F>
Moved<Lanes<T>> apply_contacts(const BlockContacts<T>& all, const typename BlockContacts<T>::NodePack& nodes,
                               const std::vector<Twist>& U, F&& visit) {
  using R = Lanes<T>;
  Vec3<R> v = nodes.v;
  Lift<R> lift = nodes.lift;
  for (std::size_t e = nodes.begin; e < nodes.end; ++e) {
    const auto& contact = all.contacts[e];
    const Vec3<R> before = v;
    const Vec3<R> v_co = surface_velocity(*contact.solid, U.front().data(), contact.arm, contact.facing.n);
    const Play<R> play = lift.play(contact.facing.n);
    v = meet(*contact.solid, contact.inside, contact.facing, v_co, v, lift);
    visit(contact, before, play, v_co, v);
  }
  return {v, lift.s};
}

// Sums for some bodies, each made when it is first asked for.
template <class Sum>
class SumByBody {
 public:
  void clear() { entries_.clear(); }
  Sum& of(std::size_t body) {
    for (auto& [known, sum] : entries_) {
      if (known == body) return sum;
    }
    return entries_.emplace_back(body, Sum{}).second;
  }
  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }

 private:
  std::vector<std::pair<std::size_t, Sum>> entries_;
};

// The responses of the snow of some blocks to bodies. Those of a few blocks are summed on their own, then all in the order
// of the blocks, whatever the threads do.
template <class T>
class Responses {
  using R = Lanes<T>;
  static constexpr std::size_t blocks_in_part = 2;
  struct Part {
    SumByBody<ImpulseOf<Doubles<R>>> impulses;
    SumByBody<SlopeOf<R>> slopes;
  };

 public:
  Responses(const std::vector<BlockContacts<T>>& blocks, std::size_t count, std::size_t bodies)
      : blocks_(blocks),
        count_(count),
        bodies_(bodies),
        parts_((count + blocks_in_part - 1) / blocks_in_part) {}

  // To bodies that move with U: the impulses, or the slopes alone.
  std::vector<BodyResponse> to(const std::vector<Twist>& U, bool slopes) {
    each_index(parts_.size(), [&](std::size_t i) {
      Part& part = parts_[i];
      part.impulses.clear(), part.slopes.clear();
      const std::size_t end = std::min(count_, (i + 1) * blocks_in_part);
      for (std::size_t b = i * blocks_in_part; b < end; ++b) {
        for (const auto& nodes : blocks_[b].nodes) add(blocks_[b], nodes, U, slopes, part);
      }
    });
    std::vector<BodyResponse> total(bodies_);
    for (const Part& part : parts_) {
      for (const auto& [body, sum] : part.impulses) {
        for (int k = 0; k < 6; ++k) total[body].impulse[k] += sum_lanes(sum.impulse[k]);
      }
      for (const auto& [body, sum] : part.slopes) {
        for (int k = 0; k < 36; ++k) total[body].slope[k] += double(sum_lanes(sum.slope[k]));
      }
    }
    return total;
  }

 private:
  static void add(const BlockContacts<T>& all, const typename BlockContacts<T>::NodePack& nodes,
                  const std::vector<Twist>& U, bool slopes, Part& part) {
    apply_contacts(all, nodes, U,
                   [&](const auto& contact, const Vec3<R>& before, const Play<R>& play, const Vec3<R>& v_co,
                       const Vec3<R>& after) {
                     if (contact.solid->body < 0) return;
                     const auto body = std::size_t(contact.solid->body);
                     if (slopes) {
                       add_slope(part.slopes.of(body), *contact.solid, contact.inside, nodes.m,
                                 contact.facing.n, contact.arm, play, v_co, before);
                     } else {
                       add_impulse(part.impulses.of(body), contact.inside, nodes.m, contact.arm, before,
                                   after);
                     }
                   });
  }

  const std::vector<BlockContacts<T>>& blocks_;
  std::size_t count_, bodies_;
  std::vector<Part> parts_;
};

}  // namespace detail

// What BodyVelocitySolver asks, where impulses and slopes come together from f(U): once for each U in a row.
template <class F>
auto whole_responses(F&& f) {
  return [&f, at = std::vector<Twist>(), known = std::vector<BodyResponse>()](const std::vector<Twist>& U,
                                                                              bool) mutable {
    if (known.empty() || U != at) known = f(U), at = U;
    return known;
  };
}

// Let the bodies among the solids move with U.
template <class T>
void set_velocities(const CoupledBodies& bodies, const std::vector<Twist>& U, std::vector<Solid<T>>& solids) {
  for (std::size_t i = 0; i < U.size(); ++i) {
    Solid<T>& solid = solids[std::size_t(bodies.solids[i])];
    solid.velocity = linear<T>(U[i].data());
    solid.omega = angular<T>(U[i].data());
  }
}

// Newton's method for U = U_0 + A P(U). The bodies of one group after another: others do not move them.
class BodyVelocitySolver {
 public:
  BodyVelocitySolver(const CoupledBodies& bodies, double dt)
      : bodies_(bodies), U_0_(bodies.start), gyration2_(U_0_.size()) {
    for (std::size_t i = 0; i < U_0_.size(); ++i) {
      for (std::size_t k = 0; k < 6; ++k) U_0_[i][k] += dt * bodies.free[i][k];
    }
    for (const BodyGroup& group : bodies.groups) {
      const std::size_t n = 6 * group.bodies.size();
      for (std::size_t i = 0; i < group.bodies.size(); ++i) {
        double linear = 0, angular = 0;
        for (std::size_t k = 6 * i; k < 6 * i + 6; ++k)
          (k < 6 * i + 3 ? linear : angular) += group.mobility[k * n + k];
        gyration2_[group.bodies[i]] = linear > 0 && angular > 0 ? linear / angular : 1;
      }
    }
  }

  // responses(U, slopes): those of the snow to each body, if the bodies move with U: their impulses, or if `slopes` is true
  // their slopes, which are asked for anew when the last ones have not brought the residual down to a tenth.
  template <class F>
  std::vector<Twist> solve(F&& responses) const {
    Guess best = evaluate(U_0_, responses);
    const double enough = accuracy * best.residual_norm;
    std::vector<BodyResponse> slopes;
    for (int k = 0; k < most_steps && best.residual_norm > enough; ++k) {
      const bool anew = slopes.empty();
      if (anew) slopes = responses(best.U, true);
      const std::vector<Twist> step = newton_step(best, slopes);
      const double before = best.residual_norm;
      double share = 1;
      for (int h = 0; h < most_halvings && best.residual_norm == before; ++h, share *= 0.5) {
        std::vector<Twist> U = best.U;
        for (std::size_t i = 0; i < U.size(); ++i) {
          for (std::size_t j = 0; j < 6; ++j) U[i][j] += share * step[i][j];
        }
        Guess next = evaluate(std::move(U), responses);
        if (next.residual_norm < best.residual_norm) best = std::move(next);
      }
      if (best.residual_norm > 0.9 * before && anew) break;  // rounding of the nodes' velocities
      if (best.residual_norm > 0.1 * before) slopes.clear();
    }
    return best.U;
  }

 private:
  static constexpr int most_steps = 12, most_halvings = 5;
  static constexpr double accuracy = 1e-6;  // of the first residual; the nodes' velocities have seven digits

  struct Guess {
    std::vector<Twist> U;
    std::vector<Twist> residual;
    double residual_norm;
  };
  template <class F>
  Guess evaluate(std::vector<Twist> U, F& responses) const {
    auto left = residual(U, responses(U, false));
    const double left_norm = norm(left);
    return {std::move(U), std::move(left), left_norm};
  }

  // U_0 + A P(U) - U
  std::vector<Twist> residual(const std::vector<Twist>& U, const std::vector<BodyResponse>& response) const {
    std::vector<Twist> out(U.size());
    for (const BodyGroup& group : bodies_.groups) {
      const std::size_t n = 6 * group.bodies.size();
      for (std::size_t r = 0; r < n; ++r) {
        const std::size_t body = group.bodies[r / 6];
        double sum = U_0_[body][r % 6] - U[body][r % 6];
        for (std::size_t c = 0; c < n; ++c)
          sum += group.mobility[r * n + c] * response[group.bodies[c / 6]].impulse[c % 6];
        out[body][r % 6] = sum;
      }
    }
    return out;
  }

  // (1 + A K)^-1 residual, with K the slopes, one block of six by six for each body
  std::vector<Twist> newton_step(const Guess& guess, const std::vector<BodyResponse>& slopes) const {
    std::vector<Twist> out(guess.U.size());
    for (const BodyGroup& group : bodies_.groups) {
      const std::size_t n = 6 * group.bodies.size();
      std::vector<double> matrix(n * n), right(n);
      for (std::size_t r = 0; r < n; ++r) {
        right[r] = guess.residual[group.bodies[r / 6]][r % 6];
        for (std::size_t c = 0; c < n; ++c) {
          const std::size_t first = c - c % 6;
          const double* slope = slopes[group.bodies[c / 6]].slope;
          double sum = r == c ? 1 : 0;
          for (std::size_t k = 0; k < 6; ++k) sum += group.mobility[r * n + first + k] * slope[6 * k + c % 6];
          matrix[r * n + c] = sum;
        }
      }
      neve::solve(matrix, right);
      for (std::size_t r = 0; r < n; ++r) out[group.bodies[r / 6]][r % 6] = right[r];
    }
    return out;
  }

  // In m/s: angular velocities count at the body's radius of gyration.
  double norm(const std::vector<Twist>& u) const {
    double sum = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      for (std::size_t k = 0; k < 6; ++k) sum += u[i][k] * u[i][k] * (k < 3 ? 1.0 : gyration2_[i]);
    }
    return std::sqrt(sum);
  }

  const CoupledBodies& bodies_;
  std::vector<Twist> U_0_;
  std::vector<double> gyration2_;  // tr A_vv / tr A_ww: squares of radii of gyration [m2], up to a factor
};

}  // namespace neve
