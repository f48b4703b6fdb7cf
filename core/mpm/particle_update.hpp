// What a step does to one particle, from values to values (Stomakhin et al. 2013, section 4.1).
//
// R is a scalar, or a pack of particles that move together. Where the values come from and go to is the business of who
// calls: core/cpu loads and stores packs of columns.
#pragma once

#include "constitutive/law.hpp"
#include "coupling/swept_contact.hpp"
#include "mpm/step_constants.hpp"

namespace neve {

// What a particle gives to the nodes of its stencil: w_ip (momentum + A (x_i - x_p) / dx) and w_ip mass; A = 0 for
// transfers without a matrix. (PolyPIC adds its further modes.)
template <class R>
struct Contribution {
  Vec3<R> momentum;  // [kg m/s]
  R mass;            // [kg]
  Mat3<R> A;         // [kg m/s], columns along the axes of x_i - x_p
};

// 1. Mass and momentum; and 3. the force times dt, for transfers that let it ride on the momentum.
template <class Transfer, class R>
NEVE_INLINE Contribution<R> contribution(const Vec3<R>& v, R m, const Mat3<R>& C, const Sym3<R>& tau, R V0,
                                         const StepConstants<scalar_t<R>>& step) {
  Contribution<R> out{v * m, m, {}};
  if constexpr (Transfer::has_matrix) out.A = Transfer::matrix(C, tau, m, V0, step.dt, step.cells);
  return out;
}

// What the nodes give back: sum_i w_ip v_i; G = sum_i w_ip v_i (x_i - x_p)^T / dx, or with gradients of weights; and the
// change of velocity sum_i w_ip (v_i - v_i^n) of transfers that keep it, and that of G.
template <class R>
struct Gathered {
  Vec3<R> v;  // [m/s]
  Mat3<R> G;  // [m/s]
  Vec3<R> change{};
  Mat3<R> G_change{};
};

template <class R>
struct Advanced {
  Vec3<R> x, v;          // [m], [m/s]
  Mat3<R> grad_v;        // [1/s]
  Mat3<R> C;             // the affine velocity of transfers that keep one [1/s]
  Mapped<R> material;    // F_E, J_P and the stress
  Vec3<R> displacement;  // x - x^n [m]
};

// F before plastic flow, (I + dt grad v) F_E.
template <class R, class Particle>
NEVE_INLINE Mat3<R> trial_deformation(const Particle& particle, const Mat3<R>& grad_v,
                                      const StepConstants<scalar_t<R>>& step) {
  const Mat3<R> F_E = particle.F_E();
  return F_E + scaled(grad_v * F_E, step.dt);
}

// 7. Deformation, plastic flow and hardening; and the stress for the next step. return_map(F_trial, J_P) is the law.
template <class R, class Particle, class Law>
NEVE_INLINE void deform(Advanced<R>& out, const Particle& particle, const StepConstants<scalar_t<R>>& step,
                        Law&& return_map) {
  out.material = return_map(trial_deformation(particle, out.grad_v, step), particle.J_P());
}

// 8. Velocity, 9. collisions with solids, and 10. position. `exchanged` is called as by move_past for each solid that it
// meets.
template <class Transfer, class R, class Particle, class Solids, class F>
NEVE_INLINE void move(Advanced<R>& out, const Particle& particle, const Gathered<R>& grid,
                      const StepConstants<scalar_t<R>>& step, const Solids& solids, F&& exchanged) {
  Vec3<R> v = Transfer::velocity(particle.v(), grid.v, grid.change, step.blend);
  if constexpr (Transfer::has_affine_change) {
    const Mat3<R> change = Transfer::velocity_gradient(grid.G_change, step.cells);
    out.C = Transfer::affine_velocity(particle.C(), out.grad_v, change, step.blend);
  } else {
    out.C = out.grad_v;
  }

  const Vec3<R> x = particle.x();
  const R m = particle.m();
  Vec3<R> path = v;
  if constexpr (Transfer::separate_position_velocity) {
    path = Transfer::position_velocity(v, grid.v, determinant(trial_deformation(particle, out.grad_v, step)),
                                       held_by_any(solids, x, m, step.skin));
  }
  move_past(solids, x, v, path, step.dt, step.cells.dx, m, exchanged);
  out.v = v;
  out.displacement = path * step.dt;
  out.x = x + out.displacement;
}

// Move a particle by one step. (On a GPU whatever is known before a collision takes registers in it: there it deforms last.)
//
// `particle` gives x, v, C, F_E, J_P and m when called for them; return_map(F_trial, J_P) is the particle's law; `exchanged`
// is called as by move_past for each solid that it meets.
template <class Transfer, class R, class Particle, class Solids, class Law, class F>
NEVE_INLINE Advanced<R> advance(const Particle& particle, const Gathered<R>& grid,
                                const StepConstants<scalar_t<R>>& step, const Solids& solids,
                                Law&& return_map, F&& exchanged) {
  Advanced<R> out;
  out.grad_v = Transfer::velocity_gradient(grid.G, step.cells);
  deform(out, particle, step, return_map);
  move<Transfer>(out, particle, grid, step, solids, exchanged);
  return out;
}

}  // namespace neve
