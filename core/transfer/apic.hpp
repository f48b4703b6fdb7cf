// APIC (Jiang et al. 2015) with the MLS-MPM stress (Hu et al. 2018): the affine velocity C travels with the particle,
// grad v := C, and the force rides on the momentum. Conserves linear and angular momentum.
//
//   (m v)_i = sum_p w_ip [ m_p v_p + (m_p C_p - dt V0_p D^-1 tau_p) (x_i - x_p) ],   C_p = D^-1 sum_i w_ip v_i (x_i - x_p)^T
#pragma once

#include "transfer/weights.hpp"

namespace neve {

struct Apic {
  static constexpr Word word{"apic", "keeps angular momentum",
                             "Jiang et al. 2015 (as quoted in public codes)", "jiang2015 hu2018"};
  static constexpr const char* options = "";        // the keys of [numerics] that it reads
  static constexpr bool keeps_C = true;             // the affine velocity travels with the particle
  static constexpr bool damps = false;              // all motions but translations fade
  static constexpr bool has_bounded_energy = true;  // no step gives the particles more than the grid had
  static constexpr bool has_change = false;         // force and momentum apart on the grid
  static constexpr bool has_matrix = true;          // the momentum carries a matrix beside v
  static constexpr bool has_affine_change = false;  // C changes by what changed on the grid
  static constexpr bool separate_position_velocity =
      false;                       // particles move with a velocity other than their own
  static constexpr int modes = 4;  // v, and the columns of a matrix
  using ScatterWeights = AffineWeights;
  using GatherWeights = AffineWeights;

  // The matrix of the momentum, per cell: columns multiply the axes of x_i - x_p. (The affine part is named before the
  // force: the order decides which product is fused with the sum.)
  template <class R>
  NEVE_INLINE static Mat3<R> matrix(const Mat3<R>& C, const Sym3<R>& tau, R m, R V0, scalar_t<R> dt,
                                    const CellScales<scalar_t<R>>& cells) {
    const Mat3<R> affine = scaled(C, m * cells.dx);
    return affine + mls_force(tau, V0 * dt, cells);
  }

  // From the gathered G = sum w v_i (x_i - x_p)^T / dx: the velocity gradient, which is C.
  template <class R>
  NEVE_INLINE static Mat3<R> velocity_gradient(const Mat3<R>& G, const CellScales<scalar_t<R>>& cells) {
    return scaled(G, cells.affine);
  }

  // v_p = v_PIC: the affine part holds the rest.
  template <class R>
  NEVE_INLINE static Vec3<R> velocity(const Vec3<R>&, const Vec3<R>& pic, const Vec3<R>&,
                                      const FlipBlend<scalar_t<R>>&) {
    return pic;
  }
};

}  // namespace neve
