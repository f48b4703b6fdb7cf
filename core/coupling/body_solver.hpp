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

// The sum over the lanes.
template <class N>
BodyResponse summed(const ResponseOf<N>& response) {
  BodyResponse sum;
  for (int k = 0; k < 6; ++k) sum.impulse[k] = sum_lanes(response.impulse[k]);
  for (int k = 0; k < 36; ++k) sum.slope[k] = sum_lanes(response.slope[k]);
  return sum;
}

// The responses of the snow of some blocks to bodies. Each block's are summed on their own, then in the order of the
// blocks, whatever the threads do.
template <class T>
class Responses {
  using R = Lanes<T>;
  using Part = std::vector<std::pair<std::size_t, ResponseOf<Doubles<R>>>>;  // by body
  using Sum = std::vector<std::pair<std::size_t, BodyResponse>>;

 public:
  Responses(const std::vector<BlockContacts<T>>& blocks, std::size_t count, std::size_t bodies)
      : blocks_(blocks), bodies_(bodies), parts_(count) {}

  // To bodies that move with U.
  std::vector<BodyResponse> to(const std::vector<Twist>& U) {
    each_index(parts_.size(), [&](std::size_t b) {
      Part part;
      for (const auto& nodes : blocks_[b].nodes) add(blocks_[b], nodes, U, part);
      parts_[b].clear();
      for (const auto& [body, response] : part) parts_[b].emplace_back(body, summed(response));
    });
    std::vector<BodyResponse> total(bodies_);
    for (const Sum& part : parts_) {
      for (const auto& [body, response] : part) total[body].add(response);
    }
    return total;
  }

 private:
  static ResponseOf<Doubles<R>>& of(std::size_t body, Part& part) {
    for (auto& [known, response] : part) {
      if (known == body) return response;
    }
    return part.emplace_back(body, ResponseOf<Doubles<R>>{}).second;
  }

  static void add(const BlockContacts<T>& all, const typename BlockContacts<T>::NodePack& nodes,
                  const std::vector<Twist>& U, Part& part) {
    apply_contacts(all, nodes, U,
                   [&](const auto& contact, const Vec3<R>& before, const Play<R>& play, const Vec3<R>& v_co,
                       const Vec3<R>& after) {
                     if (contact.solid->body < 0) return;
                     add_response(of(std::size_t(contact.solid->body), part), *contact.solid, contact.inside,
                                  nodes.m, contact.facing.n, contact.arm, play, v_co, before, after);
                   });
  }

  const std::vector<BlockContacts<T>>& blocks_;
  std::size_t bodies_;
  std::vector<Sum> parts_;
};

}  // namespace detail

// Let the bodies among the solids move with U.
template <class T>
void set_velocities(const CoupledBodies& bodies, const std::vector<Twist>& U, std::vector<Solid<T>>& solids) {
  for (std::size_t i = 0; i < U.size(); ++i) {
    Solid<T>& solid = solids[std::size_t(bodies.solids[i])];
    solid.velocity = linear<T>(U[i].data());
    solid.omega = angular<T>(U[i].data());
  }
}

// Newton's method for U = U_0 + A P(U).
class BodyVelocitySolver {
 public:
  BodyVelocitySolver(const CoupledBodies& bodies, double dt)
      : bodies_(bodies), n_(6 * bodies.solids.size()), U_0_(bodies.start) {
    for (std::size_t i = 0; i < U_0_.size(); ++i) {
      double linear = 0, angular = 0;
      for (std::size_t j = 0; j < U_0_.size(); ++j) coupled_.push_back(couples(bodies.mobility, i, j));
      for (std::size_t k = 0; k < 6; ++k) {
        U_0_[i][k] += dt * bodies.free[i][k];
        (k < 3 ? linear : angular) += bodies.mobility[(6 * i + k) * n_ + 6 * i + k];
      }
      gyration2_.push_back(linear > 0 && angular > 0 ? linear / angular : 1);
    }
  }

  // responses(U): those of the snow to each body, if the bodies move with U.
  template <class F>
  std::vector<Twist> solve(F&& responses) const {
    Guess best = evaluate(U_0_, responses);
    const double enough = accuracy * best.residual_norm;
    for (int k = 0; k < most_steps && best.residual_norm > enough; ++k) {
      const std::vector<double> step = newton_step(best.residual, best.response);
      const double before = best.residual_norm;
      double share = 1;
      for (int h = 0; h < most_halvings && best.residual_norm == before; ++h, share *= 0.5) {
        std::vector<Twist> U = best.U;
        for (std::size_t i = 0; i < n_; ++i) U[i / 6][i % 6] += share * step[i];
        Guess next = evaluate(std::move(U), responses);
        if (next.residual_norm < best.residual_norm) best = std::move(next);
      }
      if (best.residual_norm > 0.9 * before) break;  // rounding of the nodes' velocities
    }
    return best.U;
  }

 private:
  static constexpr int most_steps = 12, most_halvings = 5;
  static constexpr double accuracy = 1e-6;  // of the first residual; the nodes' velocities have seven digits

  struct Guess {
    std::vector<Twist> U;
    std::vector<BodyResponse> response;
    std::vector<double> residual;
    double residual_norm;
  };
  template <class F>
  Guess evaluate(std::vector<Twist> U, F& responses) const {
    auto response = responses(U);
    auto left = residual(U, response);
    const double left_norm = norm(left);
    return {std::move(U), std::move(response), std::move(left), left_norm};
  }

  // U_0 + A P(U) - U
  std::vector<double> residual(const std::vector<Twist>& U, const std::vector<BodyResponse>& response) const {
    std::vector<double> out(n_);
    for (std::size_t r = 0; r < n_; ++r) {
      double sum = U_0_[r / 6][r % 6] - U[r / 6][r % 6];
      for (std::size_t c = 0; c < n_; ++c) {
        if (coupled(r, c)) sum += bodies_.mobility[r * n_ + c] * response[c / 6].impulse[c % 6];
      }
      out[r] = sum;
    }
    return out;
  }

  // (1 + A K)^-1 residual, with K the slopes, one block of six by six for each body
  std::vector<double> newton_step(std::vector<double> right,
                                  const std::vector<BodyResponse>& response) const {
    std::vector<double> matrix(n_ * n_);
    for (std::size_t r = 0; r < n_; ++r) {
      for (std::size_t c = 0; c < n_; ++c) {
        double sum = r == c ? 1 : 0;
        const std::size_t body = c / 6;
        for (std::size_t k = 0; k < 6 && coupled(r, c); ++k)
          sum += bodies_.mobility[r * n_ + 6 * body + k] * response[body].slope[6 * k + c % 6];
        matrix[r * n_ + c] = sum;
      }
    }
    neve::solve(matrix, right);
    return right;
  }

  // Whether an impulse on body j moves body i: bodies that nothing joins do not.
  bool couples(const std::vector<double>& mobility, std::size_t i, std::size_t j) const {
    for (std::size_t k = 0; k < 36; ++k) {
      if (mobility[(6 * i + k / 6) * n_ + 6 * j + k % 6] != 0) return true;
    }
    return false;
  }
  bool coupled(std::size_t row, std::size_t column) const {
    return coupled_[row / 6 * U_0_.size() + column / 6];
  }

  // In m/s: angular velocities count at the body's radius of gyration.
  double norm(const std::vector<double>& u) const {
    double sum = 0;
    for (std::size_t i = 0; i < n_; ++i) sum += u[i] * u[i] * (i % 6 < 3 ? 1.0 : gyration2_[i / 6]);
    return std::sqrt(sum);
  }

  const CoupledBodies& bodies_;
  std::size_t n_;
  std::vector<Twist> U_0_;
  std::vector<char> coupled_;      // by pairs of bodies
  std::vector<double> gyration2_;  // tr A_vv / tr A_ww: squares of radii of gyration [m2], up to a factor
};

}  // namespace neve
