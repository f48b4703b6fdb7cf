// How the bodies of the engine move in a step: where they are, how impulses move them, and how they move without the snow.
#pragma once

#include <numeric>
#include <vector>

#include "rigid/carried_solids.hpp"
#include "rigid/joint_inertia.hpp"

namespace neve::rigid {

// Which trees of joints move one another.
class JoinedTrees {
 public:
  explicit JoinedTrees(std::size_t trees) : first_(trees) {
    std::iota(first_.begin(), first_.end(), std::size_t(0));
  }
  void join(const EngineModel& model, const SparseRow& row) {
    for (const auto& [dof, _] : row.entries) {
      const std::size_t a = of(model, row), b = first(std::size_t(model.dof_treeid[dof]));
      first_[std::max(a, b)] = std::min(a, b);
    }
  }
  // The first of all that `tree` is joined with.
  std::size_t first(std::size_t tree) const {
    while (first_[tree] != tree) tree = first_[tree];
    return tree;
  }
  // The first tree of those that a row joins.
  std::size_t of(const EngineModel& model, const SparseRow& row) const {
    return first(std::size_t(model.dof_treeid[row.entries.front().first]));
  }

 private:
  std::vector<std::size_t> first_;
};

class BodyDynamics {
 public:
  BodyDynamics(const EngineModel& model, const EngineData& data, std::vector<Carried> solids)
      : model_(model), data_(data), solids_(std::move(solids)) {
    motion_.resize(solids_.size());
    for (Carried& solid : solids_) {
      solid.dofs = detail::chain_of(model, solid.body);
      solid.J.resize(solid.dofs.size());
    }
  }
  const BodyMotion& motion() const { return motion_; }
  const EngineModel& model() const { return model_; }

  // Derive the motion in the next step from what the engine knows after the first half of one. A = J (M + h D + K)^-1 J^T
  // with the Jacobian J of the solids' velocities and the mass matrix M of the joints; D is the damping of joints and
  // motors, h [s] the length of the engine's last step; K is what the constraints add that hold now: a body on the ground
  // yields no more than the ground lets it.
  void update(double h, const EngineConstraints& constraints) {
    for (std::size_t i = 0; i < solids_.size(); ++i) place(model_, data_, solids_[i], i, motion_);
    group(damped_by_motors(model_, data_, h), held_by_constraints(model_, constraints));
    qacc_.assign(data_.qacc, data_.qacc + model_.dofs);
    motion_.groups.clear();
    for (const Group& g : groups_) {
      if (!g.solids.empty()) move(g, h);
    }
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      if (solids_[i].dofs.empty()) motion_.groups.push_back({{i}, std::vector<double>(36)});
      motion_.free[i] = acceleration(model_, data_, solids_[i], qacc_.data(), i, motion_);
    }
  }

  // Apply what solids exchanged with the snow in dt [s], rows of 7: impulse, moment about the origin of the frame, work. It
  // acts as a constant force and torque. Returns the first solid whose force is not finite, before any acts, or their number.
  std::size_t apply(const double* exchanged, double dt) const {
    const std::size_t n = solids_.size();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < 6; ++k) {
        if (!std::isfinite(exchanged[7 * i + k] / dt)) return i;
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t body = solids_[i].body;
      double force[3], arm[3];
      for (std::size_t k = 0; k < 3; ++k) {
        force[k] = exchanged[7 * i + k] / dt;
        arm[k] = motion_.centres[i][k] - data_.xipos[3 * body + k];
      }
      const detail::Triple moment = detail::cross(arm, force);
      double* applied = data_.xfrc_applied + 6 * body;
      for (std::size_t k = 0; k < 3; ++k) {
        applied[k] += force[k];
        applied[3 + k] += exchanged[7 * i + 3 + k] / dt + moment[k];
      }
    }
    return n;
  }

 private:
  // Degrees of freedom that move one another, with the solids on them.
  struct Group {
    std::vector<std::size_t> dofs, solids;
    std::vector<SparseRow> motors, held;
  };

  void group(std::vector<SparseRow> motors, std::vector<SparseRow> held) {
    JoinedTrees joined(model_.trees);
    for (const auto* rows : {&motors, &held}) {
      for (const SparseRow& row : *rows) joined.join(model_, row);
    }
    groups_.assign(model_.trees, {});
    place_.resize(model_.dofs);
    for (std::size_t d = 0; d < model_.dofs; ++d) {
      Group& g = groups_[joined.first(std::size_t(model_.dof_treeid[d]))];
      place_[d] = g.dofs.size();
      g.dofs.push_back(d);
    }
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      if (solids_[i].dofs.empty()) continue;
      groups_[joined.first(std::size_t(model_.dof_treeid[solids_[i].dofs[0]]))].solids.push_back(i);
    }
    for (SparseRow& row : motors) {
      if (!row.entries.empty()) groups_[joined.of(model_, row)].motors.push_back(std::move(row));
    }
    for (SparseRow& row : held) {
      if (!row.entries.empty()) groups_[joined.of(model_, row)].held.push_back(std::move(row));
    }
  }

  void move(const Group& g, double h) {
    JointInertia inertia(model_, data_, g.dofs, place_);
    bool damped = !g.motors.empty();
    for (std::size_t i = 0; i < g.dofs.size(); ++i) {
      const double damping = model_.dof_damping[g.dofs[i]];
      if (damping == 0) continue;
      damped = true;
      inertia.add_to_diagonal(i, h * damping);
    }
    for (const SparseRow& row : g.motors) inertia.add_square(row, place_);
    JointInertia stiff = inertia;
    if (damped) {  // the engine takes the damping of its own step implicitly
      inertia.factor();
      std::vector<double> q(g.dofs.size());
      for (std::size_t i = 0; i < q.size(); ++i)
        q[i] = data_.qfrc_smooth[g.dofs[i]] + data_.qfrc_constraint[g.dofs[i]];
      inertia.forward(q.data(), 0);
      inertia.backward(q.data());
      for (std::size_t i = 0; i < q.size(); ++i) qacc_[g.dofs[i]] = q[i];
    }
    for (const SparseRow& row : g.held) stiff.add_square(row, place_);
    stiff.factor();
    add_mobility(g, stiff);
  }

  // A = Y Y^T with the rows of Y = L^-1 J^T.
  void add_mobility(const Group& g, const JointInertia& inertia) {
    const std::size_t n = g.dofs.size(), rows = 6 * g.solids.size();
    std::vector<double> Y(rows * n);
    std::vector<std::size_t> first(rows);
    for (std::size_t r = 0; r < rows; ++r) {
      const Carried& solid = solids_[g.solids[r / 6]];
      for (std::size_t d = 0; d < solid.dofs.size(); ++d)
        Y[r * n + place_[solid.dofs[d]]] = solid.J[d][r % 6];
      first[r] = place_[solid.dofs[0]];
      inertia.forward(Y.data() + r * n, first[r]);
    }
    BodyGroup out{g.solids, std::vector<double>(rows * rows)};
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t c = 0; c <= r; ++c) {
        const std::size_t begin = std::max(first[r], first[c]);
        out.mobility[r * rows + c] = out.mobility[c * rows + r] =
            dot(Y.data() + r * n + begin, Y.data() + c * n + begin, n - begin);
      }
    }
    motion_.groups.push_back(std::move(out));
  }

  EngineModel model_;
  EngineData data_;
  std::vector<Carried> solids_;
  BodyMotion motion_;
  std::vector<Group> groups_;       // by the first of their trees
  std::vector<std::size_t> place_;  // of a degree of freedom among those of its group
  std::vector<double> qacc_;
};

}  // namespace neve::rigid
