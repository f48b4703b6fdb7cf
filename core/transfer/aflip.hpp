// Affine FLIP: velocity and affine velocity are both updated by what changed on the grid, and what the grid cannot resolve
// of them decays at a rate. The velocities' part is AFLIP's (Fei et al. 2021), who take C anew from the grid each step.
//
//   v_p = alpha (v_p + sum_i w_ip (v_i - v_i^n)) + (1 - alpha) sum_i w_ip v_i,   alpha = exp(-r dt)
//   C_p = alpha (C_p + D^-1 sum_i w_ip (v_i - v_i^n) (x_i - x_p)^T) + (1 - alpha) D^-1 sum_i w_ip v_i (x_i - x_p)^T
//
// To the grid as APIC. Since that is the adjoint of the way back under sum m (|v|^2 + D |C|^2), no step gives the particles
// more than the forces gave the grid, whatever alpha; momentum and angular momentum are conserved.
#pragma once

#include "transfer/affine_flip.hpp"

namespace neve {

struct Aflip : AffineFlip {
  static constexpr Word word{"aflip", "keeps angular momentum, and what it damps does not depend on the step",
                             "Fei et al. 2021 names the idea, the details are ours",
                             "fei2021 jiang2015 hu2018 brackbill1986"};
  static constexpr const char* options = "aflip_damping";  // the keys of [numerics] that it reads
  static constexpr bool separate_position_velocity = false;

  // The affine velocity, from the velocity gradient of the grid and its change.
  template <class R>
  NEVE_INLINE static Mat3<R> affine_velocity(const Mat3<R>& C, const Mat3<R>& grad_v, const Mat3<R>& change,
                                             const FlipBlend<scalar_t<R>>& blend) {
    return scaled(C + change, splat<R>(blend.flip)) + scaled(grad_v, splat<R>(blend.pic));
  }
};

}  // namespace neve
