// ASFLIP (Fei et al. 2021): APIC's affine velocity beside the FLIP blend, and positions that follow the particle's own
// velocity only where snow comes apart, so that it separates as with FLIP and does not clump as with PIC or APIC.
//
//   (m v)_i = sum_p w_ip m_p [ v_p + C_p (x_i - x_p) ],   f_i = -sum_p V0_p D^-1 tau_p w_ip (x_i - x_p)
//   v_p = v_PIC + alpha (v_p - sum_i w_ip v_i^n),   x_p += dt ( v_PIC + gamma alpha (v_p - sum_i w_ip v_i^n) )
//   gamma = 1 if det F_E of the trial state >= exp(-0.001) and no solid holds the particle, else 0
//   C_p = s C',  C' = D^-1 sum_i w_ip v_i (x_i - x_p)^T,  s^2 = min(1, 1 - alpha + alpha |C_p + dC|^2 / |C'|^2)
//
// dC is the part of C' that changed on the grid in the step. s is ours: a particle gets back what the grid did not take over
// of its velocity, and C' may hold a part of that, so that energy grew where lumps met. With s the particle has no more
// than alpha of what increments in both would leave it, and 1 - alpha of what APIC would: no more than the grid had. In
// rigid motion s = 1.
#pragma once

#include "transfer/affine_flip.hpp"

namespace neve {

struct Asflip : AffineFlip {
  static constexpr Word word{"asflip", "blends FLIP with affine velocities and lets snow come apart",
                             "Fei et al. 2021 (as quoted in public codes)",
                             "fei2021 jiang2015 hu2018 brackbill1986"};
  static constexpr const char* options = "flip_alpha flip_damping";  // the keys of [numerics] that it reads
  static constexpr bool separate_position_velocity = true;

  // The affine velocity, from the velocity gradient of the grid and its change.
  template <class R>
  NEVE_INLINE static Mat3<R> affine_velocity(const Mat3<R>& C, const Mat3<R>& grad_v, const Mat3<R>& change,
                                             const FlipBlend<scalar_t<R>>& blend) {
    using T = scalar_t<R>;
    constexpr T rounding = T(1) + 16 * std::numeric_limits<T>::epsilon();
    const R whole = square(grad_v), allowed = whole * blend.pic + square(C + change) * blend.flip;
    const auto more = whole > allowed * rounding;
    const R s = sqrt(allowed / select(more, whole, splat<R>(1)));
    return scaled(grad_v, select(more, s, splat<R>(1)));
  }

  // The velocity that positions follow.
  template <class R, class M>
  NEVE_INLINE static Vec3<R> position_velocity(const Vec3<R>& v, const Vec3<R>& pic, R J_trial, M held) {
    constexpr double apart = 0.99900049983337499;  // exp(-0.001)
    return select((J_trial >= scalar_t<R>(apart)) & negated(held), v, pic);
  }

 private:
  template <class R>
  NEVE_INLINE static R square(const Mat3<R>& A) {
    return dot(A.c0, A.c0) + dot(A.c1, A.c1) + dot(A.c2, A.c2);
  }
};

}  // namespace neve
