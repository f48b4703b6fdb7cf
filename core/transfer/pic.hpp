// PIC (Harlow 1964): particles carry their velocity alone and take it anew from the grid, which damps all but
// translations. The classic force rides on the momentum.
//
//   (m v)_i = sum_p w_ip m_p v_p - dt sum_p V0_p tau_p grad w_ip,   v_p = sum_i w_ip v_i,   grad v_p = sum_i v_i grad w_ip^T
#pragma once

#include "transfer/weights.hpp"

namespace neve {

struct Pic {
  static constexpr Word word{"pic", "damps all but translations", "Harlow 1964", "harlow1964"};
  static constexpr const char* options = "";        // the keys of [numerics] that it reads
  static constexpr bool keeps_C = false;            // the affine velocity travels with the particle
  static constexpr bool damps = true;               // all motions but translations fade
  static constexpr bool has_bounded_energy = true;  // no step gives the particles more than the grid had
  static constexpr bool has_change = false;
  static constexpr bool has_matrix = true;
  static constexpr bool has_affine_change = false;  // C changes by what changed on the grid
  static constexpr bool separate_position_velocity = false;
  static constexpr int modes = 4;
  using ScatterWeights = GradientWeights;
  using GatherWeights = GradientWeights;

  template <class R>
  NEVE_INLINE static Mat3<R> matrix(const Mat3<R>&, const Sym3<R>& tau, R, R V0, scalar_t<R> dt,
                                    const CellScales<scalar_t<R>>& cells) {
    return gradient_force(tau, V0 * dt, cells);
  }

  template <class R>
  NEVE_INLINE static Mat3<R> velocity_gradient(const Mat3<R>& G, const CellScales<scalar_t<R>>& cells) {
    return scaled(G, cells.gradient);
  }

  template <class R>
  NEVE_INLINE static Vec3<R> velocity(const Vec3<R>&, const Vec3<R>& pic, const Vec3<R>&,
                                      const FlipBlend<scalar_t<R>>&) {
    return pic;
  }
};

}  // namespace neve
