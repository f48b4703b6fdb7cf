// Bodies in the equations of an implicit step: their velocities at its end are unknown, as those of the nodes are.
//
// Without the snow the bodies would move with U_0 = U_n + dt a, and with its impulses P they move with U_0 + A P (see
// coupling/coupled_bodies.hpp). Of each group of joined bodies A = L L^T with a column for each of its ways to move, and
//
//     U = U_0 + L q,   q = L^T P,
//
// so that the q are as many unknowns as ways to move, and the incremental potential has 1/2 |q|^2 of them: of a free body
// the kinetic energy of what the snow changes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "coupling/coupled_bodies.hpp"

namespace neve {

class BodyUnknowns {
 public:
  // Bodies joined to one another that snow touches.
  struct Group {
    std::vector<std::size_t> bodies;
    std::size_t first = 0, rank = 0;  // of its unknowns; their number
    std::vector<double> L;            // (6 bodies, rank), row by row
    std::vector<std::size_t> pivots;  // rows of L which are those of a lower triangular matrix
    std::vector<double> S;            // Cholesky factor of 1 + L^T K L, K the snow that the bodies take along
    std::array<std::vector<double>, 3>
        t;  // the q of a velocity of 1 m/s along each axis; none where joints forbid it
    double at(std::size_t r, std::size_t k) const { return L[r * rank + k]; }
  };

  // Of the bodies that are `touched`, in a step of dt [s].
  void find(const CoupledBodies& bodies, double dt, const std::vector<bool>& touched) {
    groups_.clear(), count_ = 0;
    U_0_ = U_start_ = bodies.start;
    for (std::size_t i = 0; i < U_0_.size(); ++i) {
      for (std::size_t k = 0; k < 6; ++k) U_0_[i][k] += dt * bodies.free[i][k];
    }
    for (const BodyGroup& group : bodies.groups) {
      if (std::none_of(group.bodies.begin(), group.bodies.end(), [&](std::size_t b) { return touched[b]; }))
        continue;
      Group g;
      g.bodies = group.bodies;
      factor(group.mobility, g);
      if (g.rank == 0) continue;
      g.first = count_, count_ += g.rank;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> t(6 * g.bodies.size());
        for (std::size_t i = 0; i < g.bodies.size(); ++i) t[6 * i + axis] = 1;
        g.t[axis] = unknowns_of(g, t);
      }
      groups_.push_back(std::move(g));
    }
  }

  std::size_t count() const { return count_; }
  const std::vector<Group>& groups() const { return groups_; }

  // The q with which bodies go on as they did; zero where they cannot.
  std::vector<double> as_before() const {
    std::vector<double> q(count_);
    for (const Group& g : groups_) {
      std::vector<double> change(6 * g.bodies.size());
      for (std::size_t r = 0; r < change.size(); ++r)
        change[r] = U_start_[g.bodies[r / 6]][r % 6] - U_0_[g.bodies[r / 6]][r % 6];
      const std::vector<double> found = unknowns_of(g, change);
      std::copy(found.begin(), found.end(), q.begin() + std::ptrdiff_t(g.first));
    }
    return q;
  }

  // L q of each body.
  std::vector<Twist> changes(const std::vector<double>& q) const {
    std::vector<Twist> out(U_0_.size());
    for (const Group& g : groups_) {
      for (std::size_t r = 0; r < 6 * g.bodies.size(); ++r) {
        double sum = 0;
        for (std::size_t k = 0; k < g.rank; ++k) sum += g.at(r, k) * q[g.first + k];
        out[g.bodies[r / 6]][r % 6] = sum;
      }
    }
    return out;
  }
  // U_0 + L q.
  std::vector<Twist> velocities(const std::vector<double>& q) const {
    std::vector<Twist> out = changes(q);
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (std::size_t k = 0; k < 6; ++k) out[i][k] += U_0_[i][k];
    }
    return out;
  }
  // L^T P.
  std::vector<double> transposed(const std::vector<Twist>& P) const {
    std::vector<double> out(count_);
    for (const Group& g : groups_) {
      for (std::size_t r = 0; r < 6 * g.bodies.size(); ++r) {
        for (std::size_t k = 0; k < g.rank; ++k) out[g.first + k] += g.at(r, k) * P[g.bodies[r / 6]][r % 6];
      }
    }
    return out;
  }
  // Impulses P with L^T P = q, at as few places as there are unknowns.
  std::vector<Twist> impulses_of(const std::vector<double>& q) const {
    std::vector<Twist> out(U_0_.size());
    for (const Group& g : groups_) {
      for (std::size_t k = g.rank; k-- > 0;) {
        double sum = q[g.first + k];
        for (std::size_t later = k + 1; later < g.rank; ++later)
          sum -= g.at(g.pivots[later], k) * of(out, g, g.pivots[later]);
        of(out, g, g.pivots[k]) = sum / g.at(g.pivots[k], k);
      }
    }
    return out;
  }

  // Take the snow that each body takes along, K (6, 6) [kg, ...] of each, into account from now on.
  void load(const std::vector<std::array<double, 36>>& K) {
    for (Group& g : groups_) {
      g.S.assign(g.rank * g.rank, 0.0);
      for (std::size_t k = 0; k < g.rank; ++k) g.S[k * g.rank + k] = 1;
      for (std::size_t i = 0; i < g.bodies.size(); ++i) add_load(g, i, K[g.bodies[i]]);
      for (std::size_t r = 0; r < g.rank; ++r) {
        for (std::size_t c = 0; c <= r; ++c) {
          double sum = g.S[r * g.rank + c];
          for (std::size_t k = 0; k < c; ++k) sum -= g.S[r * g.rank + k] * g.S[c * g.rank + k];
          g.S[r * g.rank + c] = r == c ? std::sqrt(sum) : sum / g.S[c * g.rank + c];
        }
      }
    }
  }
  // S^-1 r, whose square is r . (1 + L^T K L)^-1 r.
  std::vector<double> halfway(const std::vector<double>& r) const {
    std::vector<double> out = r;
    for (const Group& g : groups_) {
      double* y = out.data() + g.first;
      for (std::size_t k = 0; k < g.rank; ++k) {
        for (std::size_t j = 0; j < k; ++j) y[k] -= g.S[k * g.rank + j] * y[j];
        y[k] /= g.S[k * g.rank + k];
      }
    }
    return out;
  }
  // (1 + L^T K L)^-1 r.
  std::vector<double> precondition(const std::vector<double>& r) const {
    std::vector<double> out = halfway(r);
    for (const Group& g : groups_) {
      double* y = out.data() + g.first;
      for (std::size_t k = g.rank; k-- > 0;) {
        for (std::size_t j = k + 1; j < g.rank; ++j) y[k] -= g.S[j * g.rank + k] * y[j];
        y[k] /= g.S[k * g.rank + k];
      }
    }
    return out;
  }

 private:
  static constexpr double least_pivot = 1e-10;  // of a row's own mobility
  static constexpr double representable = 1e-6;

  static double& of(std::vector<Twist>& P, const Group& g, std::size_t row) {
    return P[g.bodies[row / 6]][row % 6];
  }

  // L with A = L L^T by Cholesky's method, in the order of the largest pivots, of A scaled to ones on its diagonal.
  static void factor(const std::vector<double>& A, Group& g) {
    const std::size_t n = 6 * g.bodies.size();
    std::vector<double> scale(n), left(n);
    for (std::size_t r = 0; r < n; ++r) {
      const double own = A[r * n + r];
      if (own > 0) scale[r] = std::sqrt(own), left[r] = 1;
    }
    std::vector<std::vector<double>> columns;
    while (columns.size() < n) {
      const auto p = std::size_t(std::max_element(left.begin(), left.end()) - left.begin());
      if (!(left[p] > least_pivot)) break;
      std::vector<double> column(n);
      const double root = std::sqrt(left[p]);
      for (std::size_t r = 0; r < n; ++r) {
        if (!(left[r] > 0)) continue;
        double sum = A[r * n + p] / (scale[r] * scale[p]);
        for (const auto& before : columns) sum -= before[r] * before[p];
        column[r] = r == p ? root : sum / root;
      }
      for (std::size_t r = 0; r < n; ++r)
        left[r] = r == p ? 0 : std::max(left[r] - column[r] * column[r], 0.0);
      g.pivots.push_back(p);
      columns.push_back(std::move(column));
    }
    g.rank = columns.size();
    g.L.resize(n * g.rank);
    for (std::size_t r = 0; r < n; ++r) {
      for (std::size_t k = 0; k < g.rank; ++k) g.L[r * g.rank + k] = scale[r] * columns[k][r];
    }
  }

  // The q with L q = dU; zero if there is none.
  static std::vector<double> unknowns_of(const Group& g, const std::vector<double>& dU) {
    std::vector<double> q(g.rank);
    for (std::size_t k = 0; k < g.rank; ++k) {
      double sum = dU[g.pivots[k]];
      for (std::size_t j = 0; j < k; ++j) sum -= g.at(g.pivots[k], j) * q[j];
      q[k] = sum / g.at(g.pivots[k], k);
    }
    double wrong = 0, whole = 0;
    for (std::size_t r = 0; r < dU.size(); ++r) {
      double sum = -dU[r];
      for (std::size_t k = 0; k < g.rank; ++k) sum += g.at(r, k) * q[k];
      wrong = std::max(wrong, std::abs(sum)), whole = std::max(whole, std::abs(dU[r]));
    }
    if (!(wrong <= representable * whole)) q.assign(g.rank, 0.0);
    return q;
  }

  static void add_load(Group& g, std::size_t body, const std::array<double, 36>& K) {
    for (std::size_t k = 0; k < g.rank; ++k) {
      double KL[6] = {};
      for (std::size_t r = 0; r < 6; ++r) {
        for (std::size_t c = 0; c < 6; ++c) KL[r] += K[6 * r + c] * g.at(6 * body + c, k);
      }
      for (std::size_t j = 0; j < g.rank; ++j) {
        for (std::size_t r = 0; r < 6; ++r) g.S[j * g.rank + k] += g.at(6 * body + r, j) * KL[r];
      }
    }
  }

  std::vector<Group> groups_;
  std::size_t count_ = 0;
  std::vector<Twist> U_0_, U_start_;
};

}  // namespace neve
