// The PIC/FLIP blend of Stomakhin et al. 2013 (section 4.1, steps 3 and 8), with the classic force.
//
//   f_i = -sum_p V0_p tau_p grad w_ip,   grad v_p = sum_i v_i grad w_ip^T
//   v_p = (1 - alpha) sum_i w_ip v_i + alpha (v_p + sum_i w_ip (v_i - v_i^n))
//
// Force and momentum stay apart on the grid, so that no force means a change of exactly zero.
#pragma once

#include "transfer/weights.hpp"

namespace neve {

struct Flip {
  static constexpr Word word{"flip", "blends FLIP and PIC",
                             "Stomakhin et al. 2013 (as quoted in public codes)", "brackbill1986 zhu2005"};
  static constexpr const char* options = "flip_alpha flip_damping";  // the keys of [numerics] that it reads
  static constexpr bool keeps_C = false;            // the affine velocity travels with the particle
  static constexpr bool damps = false;              // all motions but translations fade
  static constexpr bool has_bounded_energy = true;  // no step gives the particles more than the grid had
  static constexpr bool has_change = true;
  static constexpr bool has_matrix = false;
  static constexpr bool has_affine_change = false;  // C changes by what changed on the grid
  static constexpr bool separate_position_velocity = false;
  static constexpr int modes = 4;
  using ScatterWeights = GradientWeights;
  using GatherWeights = GradientWeights;

  // The matrix of the force, per cell.
  template <class R>
  NEVE_INLINE static Mat3<R> force(const Sym3<R>& tau, R V0, const CellScales<scalar_t<R>>& cells) {
    return gradient_force(tau, V0, cells);
  }

  template <class R>
  NEVE_INLINE static Mat3<R> velocity_gradient(const Mat3<R>& G, const CellScales<scalar_t<R>>& cells) {
    return scaled(G, cells.gradient);
  }

  template <class R>
  NEVE_INLINE static Vec3<R> velocity(const Vec3<R>& v, const Vec3<R>& pic, const Vec3<R>& change,
                                      const FlipBlend<scalar_t<R>>& blend) {
    const Vec3<R> flip = v + change;
    return pic * blend.pic + flip * blend.flip;
  }
};

}  // namespace neve
