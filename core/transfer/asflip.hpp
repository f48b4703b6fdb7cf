// ASFLIP (Fei et al. 2021): APIC's affine velocity beside the FLIP blend, and positions that follow the particle's own
// velocity only where snow comes apart, so that it separates as with FLIP and does not clump as with PIC or APIC.
//
//   (m v)_i = sum_p w_ip m_p [ v_p + C_p (x_i - x_p) ],   f_i = -sum_p V0_p D^-1 tau_p w_ip (x_i - x_p)
//   v_p = v_PIC + alpha (v_p - sum_i w_ip v_i^n),   x_p += dt ( v_PIC + gamma alpha (v_p - sum_i w_ip v_i^n) )
//   gamma = 1 if det F_E of the trial state >= exp(-0.001) and no solid holds the particle, else 0
#pragma once

#include "transfer/apic.hpp"
#include "transfer/flip.hpp"

namespace neve {

struct Asflip {
  // Unbounded: a particle gets back what the grid did not take over of its velocity, while its affine velocity already
  // holds a part of that. Where lumps collide at several wave speeds it gains.
  static constexpr Word word{
      "asflip", "blends FLIP with affine velocities and lets snow come apart, but its energy has no bound",
      "Fei et al. 2021 (as quoted in public codes)", "fei2021 jiang2015 hu2018 brackbill1986"};
  static constexpr const char* options = "flip_alpha flip_damping";  // the keys of [numerics] that it reads
  static constexpr bool keeps_C = true;              // the affine velocity travels with the particle
  static constexpr bool damps = false;               // all motions but translations fade
  static constexpr bool has_bounded_energy = false;  // no step gives the particles more than the grid had
  static constexpr bool has_change = true;
  static constexpr bool has_matrix = true;
  static constexpr bool has_affine_change = false;  // C changes by what changed on the grid
  static constexpr bool separate_position_velocity = true;
  static constexpr int modes = 4;
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

  // The velocity that positions follow.
  template <class R, class M>
  NEVE_INLINE static Vec3<R> position_velocity(const Vec3<R>& v, const Vec3<R>& pic, R J_trial, M held) {
    constexpr double apart = 0.99900049983337499;  // exp(-0.001)
    return select((J_trial >= scalar_t<R>(apart)) & negated(held), v, pic);
  }
};

}  // namespace neve
