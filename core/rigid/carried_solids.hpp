// Solids that the engine's bodies carry: where they are, and how they move with the engine's degrees of freedom.
#pragma once

#include <vector>

#include "coupling/coupled_bodies.hpp"
#include "rigid/engine_arrays.hpp"

namespace neve::rigid {

// A solid on a body of the engine.
struct Carried {
  std::size_t body;
  std::array<double, 12> frame;   // its axes and its origin in those of the body, rows of 4
  std::vector<std::size_t> dofs;  // the degrees of freedom that move it, rising
  std::vector<std::array<double, 6>>
      J;  // what each of them gives it: velocity of its origin, angular velocity
};

namespace detail {

using Triple = std::array<double, 3>;
inline Triple cross(const double* a, const double* b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The degrees of freedom of a body and of all that carry it.
inline std::vector<std::size_t> chain_of(const EngineModel& model, std::size_t body) {
  while (body != 0 && model.body_dofnum[body] == 0) body = std::size_t(model.body_parentid[body]);
  std::vector<std::size_t> found;
  if (body == 0) return found;
  for (int d = model.body_dofadr[body] + model.body_dofnum[body] - 1; d >= 0; d = model.dof_parentid[d])
    found.push_back(std::size_t(d));
  return {found.rbegin(), found.rend()};
}

// From the centre of mass that the engine's motions are about to a point.
inline Triple arm_of(const EngineModel& model, const EngineData& data, std::size_t body, const double* x) {
  const double* about = data.subtree_com + 3 * model.body_rootid[body];
  return {x[0] - about[0], x[1] - about[1], x[2] - about[2]};
}

}  // namespace detail

// Put solids i of `motion` where their bodies are, with their Jacobians and velocities. A degree of freedom that turns with
// `a` and moves with `l` at the point c gives a point x the velocity l + a x (x - c).
inline void place(const EngineModel& model, const EngineData& data, Carried& solid, std::size_t i,
                  BodyMotion& motion) {
  const double *R = data.xmat + 9 * solid.body, *x = data.xpos + 3 * solid.body;
  for (std::size_t r = 0; r < 3; ++r) {
    double row[4];
    for (std::size_t c = 0; c < 4; ++c) {
      row[c] =
          R[3 * r] * solid.frame[c] + R[3 * r + 1] * solid.frame[4 + c] + R[3 * r + 2] * solid.frame[8 + c];
    }
    for (std::size_t c = 0; c < 3; ++c) motion.rotations[i][3 * r + c] = row[c];
    motion.centres[i][r] = x[r] + row[3];
  }
  const detail::Triple arm = detail::arm_of(model, data, solid.body, motion.centres[i].data());
  Twist rate{};
  for (std::size_t d = 0; d < solid.dofs.size(); ++d) {
    const double *a = data.cdof + 6 * solid.dofs[d], *l = a + 3, speed = data.qvel[solid.dofs[d]];
    const detail::Triple turned = detail::cross(a, arm.data());
    solid.J[d] = {l[0] + turned[0], l[1] + turned[1], l[2] + turned[2], a[0], a[1], a[2]};
    for (std::size_t k = 0; k < 6; ++k) rate[k] += solid.J[d][k] * speed;
  }
  motion.start[i] = rate;
}

// The acceleration of a solid whose degrees of freedom have the accelerations `qacc`: J qacc, and what it has without them,
// since a point goes on to be moved as its place changes: the engine's rates of change of a and l, and w x v.
inline Twist acceleration(const EngineModel& model, const EngineData& data, const Carried& solid,
                          const double* qacc, std::size_t i, const BodyMotion& motion) {
  Twist out{};
  double turning[3] = {}, moving[3] = {};
  for (std::size_t d = 0; d < solid.dofs.size(); ++d) {
    const double *rate = data.cdof_dot + 6 * solid.dofs[d], speed = data.qvel[solid.dofs[d]];
    for (std::size_t k = 0; k < 6; ++k) out[k] += solid.J[d][k] * qacc[solid.dofs[d]];
    for (std::size_t k = 0; k < 3; ++k) turning[k] += rate[k] * speed, moving[k] += rate[3 + k] * speed;
  }
  const detail::Triple arm = detail::arm_of(model, data, solid.body, motion.centres[i].data());
  const detail::Triple turned = detail::cross(turning, arm.data()),
                       swung = detail::cross(motion.start[i].data() + 3, motion.start[i].data());
  for (std::size_t k = 0; k < 3; ++k) out[k] += moving[k] + turned[k] + swung[k], out[3 + k] += turning[k];
  return out;
}

}  // namespace neve::rigid
