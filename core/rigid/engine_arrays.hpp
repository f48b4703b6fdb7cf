// What the core reads of the rigid-body engine, MuJoCo, in the engine's own memory. All are arrays of its documentation, by
// their names there; quantities of motion are in world axes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace neve::rigid {

// What stays as it is while a model lives.
struct EngineModel {
  std::size_t dofs = 0, trees = 0, actuators = 0;
  const std::int32_t *body_rootid, *body_parentid, *body_dofadr, *body_dofnum;
  const std::int32_t *dof_parentid, *dof_treeid;
  const std::int32_t *M_rownnz, *M_rowadr, *M_colind;  // rows of the lower triangle of M
  const double* dof_damping;
  const std::int32_t* actuator_biastype;
  const double* actuator_biasprm;  // rows of `bias_numbers`
  std::size_t bias_numbers = 0;
  const bool* actuator_forcelimited;
  const double* actuator_forcerange;  // rows of 2
  // Values of the engine's enumerations: a bias that falls with the speed; a constraint that holds nothing now; and those that
  // count with each of their rows (of contacts only the normal does), a bit for each.
  std::int32_t affine = 0, satisfied = 0;
  std::uint32_t whole_kinds = 0;
};

// What changes from step to step, in place.
struct EngineData {
  const double *xpos, *xmat, *xipos, *subtree_com;  // of bodies
  const double *cdof, *cdof_dot;                    // of degrees of freedom: angular part, then linear part
  const double *qvel, *qacc, *qfrc_smooth, *qfrc_constraint;
  const double* M;
  const double* actuator_force;
  const std::int32_t *moment_rownnz, *moment_rowadr, *moment_colind;
  const double* actuator_moment;
  double* xfrc_applied;  // of bodies: force and torque at the centre of mass
};

// The constraints of the moment. J: rows of all degrees of freedom, or sparse where `colind` is there.
struct EngineConstraints {
  std::size_t count = 0, contacts = 0;
  const std::int32_t *type = nullptr, *state = nullptr;
  const double *J = nullptr, *D = nullptr;
  const std::int32_t *rownnz = nullptr, *rowadr = nullptr, *colind = nullptr;
  const std::int32_t* contact_address =
      nullptr;  // the first row of each contact, along its normal; below 0: none
};

}  // namespace neve::rigid
