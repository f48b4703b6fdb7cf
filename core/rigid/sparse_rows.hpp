// Rows of the engine's degrees of freedom whose squares add to inertia: motors that slow down, constraints that hold.
#pragma once

#include <utility>
#include <vector>

#include "rigid/engine_arrays.hpp"

namespace neve::rigid {

struct SparseRow {
  double weight;                                        // of the square
  std::vector<std::pair<std::size_t, double>> entries;  // degree of freedom, value; none is zero
};

namespace detail {

inline SparseRow row_of(double weight, std::size_t count, const std::int32_t* dof, const double* value) {
  SparseRow row{weight, {}};
  for (std::size_t k = 0; k < count; ++k) {
    if (value[k] != 0) row.entries.emplace_back(dof ? std::size_t(dof[k]) : k, value[k]);
  }
  return row;
}

}  // namespace detail

// The damping of motors at their joints in a step of h [s], which the engine takes implicitly: the force of an affine
// actuator falls by -biasprm[2] for each unit of its speed (MuJoCo's affine bias), unless it is at its limit.
inline std::vector<SparseRow> damped_by_motors(const EngineModel& model, const EngineData& data, double h) {
  std::vector<SparseRow> rows;
  for (std::size_t i = 0; i < model.actuators; ++i) {
    const double rate = -model.actuator_biasprm[model.bias_numbers * i + 2], force = data.actuator_force[i];
    const double* range = model.actuator_forcerange + 2 * i;
    const bool at_limit = model.actuator_forcelimited[i] && !(range[0] < force && force < range[1]);
    if (model.actuator_biastype[i] != model.affine || !(rate > 0) || at_limit) continue;
    const auto first = std::size_t(data.moment_rowadr[i]);
    rows.push_back(detail::row_of(h * rate, std::size_t(data.moment_rownnz[i]), data.moment_colind + first,
                                  data.actuator_moment + first));
  }
  return rows;
}

// What constraints add: one that holds answers an acceleration a with the force D (a_ref - J a) (MuJoCo's documentation,
// computation, soft constraints). Of contacts the normal counts alone: friction holds only up to its cone. Equalities hold
// always, limits and contacts where the bodies press on them.
inline std::vector<SparseRow> held_by_constraints(const EngineModel& model, const EngineConstraints& all) {
  std::vector<char> counts(all.count);
  for (std::size_t i = 0; i < all.count; ++i) counts[i] = char(model.whole_kinds >> all.type[i] & 1u);
  for (std::size_t c = 0; c < all.contacts; ++c) {
    if (all.contact_address[c] >= 0) counts[std::size_t(all.contact_address[c])] = 1;
  }
  std::vector<SparseRow> rows;
  for (std::size_t i = 0; i < all.count; ++i) {
    if (!counts[i] || all.state[i] == model.satisfied) continue;
    if (all.colind) {
      const auto first = std::size_t(all.rowadr[i]);
      rows.push_back(detail::row_of(all.D[i], std::size_t(all.rownnz[i]), all.colind + first, all.J + first));
    } else {
      rows.push_back(detail::row_of(all.D[i], model.dofs, nullptr, all.J + model.dofs * i));
    }
  }
  return rows;
}

}  // namespace neve::rigid
