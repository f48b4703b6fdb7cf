// What the affine transfers with a FLIP blend share: to the grid as APIC, the velocity back as FLIP.
#pragma once

#include "transfer/apic.hpp"
#include "transfer/flip.hpp"

namespace neve {

struct AffineFlip {
  static constexpr bool keeps_C = true;             // the affine velocity travels with the particle
  static constexpr bool damps = false;              // all motions but translations fade
  static constexpr bool has_bounded_energy = true;  // no step gives the particles more than the grid had
  static constexpr bool has_change = true;
  static constexpr bool has_matrix = true;
  static constexpr bool has_affine_change = true;  // C changes by what changed on the grid
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
};

}  // namespace neve
