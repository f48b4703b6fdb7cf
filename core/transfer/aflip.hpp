// Affine FLIP: velocity and affine velocity are both updated by what changed on the grid, and what the grid cannot resolve
// of them decays at a rate. The velocities' part is AFLIP's (Fei et al. 2021), who take C anew from the grid each step.
//
//   v_p = alpha (v_p + sum_i w_ip (v_i - v_i^n)) + (1 - alpha) sum_i w_ip v_i,   alpha = exp(-r dt)
//   C_p = alpha (C_p + D^-1 sum_i w_ip (v_i - v_i^n) (x_i - x_p)^T) + (1 - alpha) D^-1 sum_i w_ip v_i (x_i - x_p)^T
//
// To the grid as APIC. Since that is the adjoint of the way back under sum m (|v|^2 + D |C|^2), no step gives the particles
// more than the forces gave the grid, whatever alpha; momentum and angular momentum are conserved.
#pragma once

#include "transfer/apic.hpp"
#include "transfer/flip.hpp"

namespace neve {

struct Aflip {
  static constexpr Word word{"aflip", "keeps angular momentum, and what it damps does not depend on the step",
                             "Fei et al. 2021 names the idea, the details are ours",
                             "fei2021 jiang2015 hu2018 brackbill1986"};
  static constexpr const char* options = "aflip_damping";  // the keys of [numerics] that it reads
  static constexpr bool keeps_C = true;                    // the affine velocity travels with the particle
  static constexpr bool damps = false;                     // all motions but translations fade
  static constexpr bool has_bounded_energy = true;  // no step gives the particles more than the grid had
  static constexpr bool has_change = true;
  static constexpr bool has_matrix = true;
  static constexpr bool separate_position_velocity = false;
  static constexpr int modes = 4;
  static constexpr bool has_affine_change = true;  // C changes by what changed on the grid
  using ScatterWeights = AffineWeights;
  using GatherWeights = AffineWeights;

  template <class R>
  NEVE_INLINE static Mat3<R> matrix(const Mat3<R>& C, const Sym3<R>&, R m, R, scalar_t<R>,
                                    const CellScales<scalar_t<R>>& cells) {
    return scaled(C, m * cells.dx);
  }

  template <class R>
  NEVE_INLINE static Mat3<R> force(const Sym3<R>& tau, R V0, const CellScales<scalar_t<R>>& cells) {
    return mls_force(tau, V0, cells);
  }

  template <class R>
  NEVE_INLINE static Mat3<R> velocity_gradient(const Mat3<R>& G, const CellScales<scalar_t<R>>& cells) {
    return Apic::velocity_gradient(G, cells);
  }

  template <class R>
  NEVE_INLINE static Vec3<R> velocity(const Vec3<R>& v, const Vec3<R>& pic, const Vec3<R>& change,
                                      const FlipBlend<scalar_t<R>>& blend) {
    return Flip::velocity(v, pic, change, blend);
  }

  // The affine velocity, from the velocity gradient of the grid and its change.
  template <class R>
  NEVE_INLINE static Mat3<R> affine_velocity(const Mat3<R>& C, const Mat3<R>& grad_v, const Mat3<R>& change,
                                             const FlipBlend<scalar_t<R>>& blend) {
    return scaled(C + change, splat<R>(blend.flip)) + scaled(grad_v, splat<R>(blend.pic));
  }
};

}  // namespace neve
