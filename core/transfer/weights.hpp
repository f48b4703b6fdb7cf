// The weights of one axis that transfers scatter and gather with: w[0] are the spline's, the rest is the transfer's
// choice. f is the fraction of the particle's place between the stencil's first node and the next, in cells.
#pragma once

#include "math/mat3.hpp"
#include "transfer/scales.hpp"

namespace neve {

// w, dw/dx_p [1/cell]: the classic gradient. `stiffness` bounds sum_i |g_i . a|^2 / w_i over unit vectors a, with g_i what
// turns the velocity of node i into a velocity gradient [cells^-2]: see neve.mpm.time_step.
struct GradientWeights {
  static constexpr int count = 2;
  template <class S>
  static constexpr double stiffness = S::sharpness;
  template <class S, class R>
  NEVE_INLINE static void axis(R f, R (*w)[4]) {
    S::weights(f, w[0], w[1]);
  }
};

// w, w z with z = x_i - x_p [cells]: affine velocities and the MLS force.
struct AffineWeights {
  static constexpr int count = 2;
  template <class S>
  static constexpr double stiffness = S::inverse_inertia;  // exactly, wherever the particle is
  template <class S, class R>
  NEVE_INLINE static void axis(R f, R (*w)[4]) {
    R dw[4];
    S::weights(f, w[0], dw);
    for (int k = 0; k < S::nodes; ++k) w[1][k] = w[0][k] * S::template offset<R>(f, k);
  }
};

// phi_2 of modes.hpp at the nodes.
template <class S, class R>
NEVE_INLINE void second_mode(R f, const R* w, R* phi) {
  using T = scalar_t<R>;
  R third = splat<R>(0);
  for (int k = 0; k < S::nodes; ++k) {
    const R z = S::template offset<R>(f, k);
    third = third + w[k] * z * z * z;
  }
  const R slope = third * T(S::inverse_inertia);
  for (int k = 0; k < S::nodes; ++k) {
    const R z = S::template offset<R>(f, k);
    phi[k] = (z - slope) * z - T(1 / S::inverse_inertia);
  }
}

// <phi_2, phi_2> = sum w phi_2^2 where the fraction is f: nothing on the border of a cell of the quadratic spline.
template <class S, class R>
NEVE_INLINE R square_norm(R f) {
  R w[4], dw[4], phi[4], norm = splat<R>(0);
  S::weights(f, w, dw);
  second_mode<S>(f, w, phi);
  for (int k = 0; k < S::nodes; ++k) norm = norm + w[k] * phi[k] * phi[k];
  return norm;
}

// w, w z, w phi_2: what a mode brings to the nodes.
struct QuadraticWeights {
  static constexpr int count = 3;
  template <class S>
  static constexpr double stiffness = AffineWeights::stiffness<S>;
  template <class S, class R>
  NEVE_INLINE static void axis(R f, R (*w)[4]) {
    AffineWeights::axis<S>(f, w);
    R phi[4];
    second_mode<S>(f, w[0], phi);
    for (int k = 0; k < S::nodes; ++k) w[2][k] = w[0][k] * phi[k];
  }
};

// w, w z, and the weights d with sum d phi_2 = 1, sum d = sum d z = 0: what takes the coefficient of phi_2 from the nodes.
// In general d = w phi_2 / sum w phi_2^2. On the three nodes of the quadratic spline that is (1, -2, 1) / 2 wherever
// the particle is, and 0/0 on the border of its cell; there a node without weight may have no mass and so no velocity,
// and the mode, which no node feels, is dropped.
struct QuadraticDuals {
  static constexpr int count = 3;
  template <class S, class R>
  NEVE_INLINE static void axis(R f, R (*w)[4]) {
    using T = scalar_t<R>;
    AffineWeights::axis<S>(f, w);
    if constexpr (S::nodes == 3) {
      const R least = min(w[0][0], w[0][2]);
      const R half = select(least > T(1e-10), splat<R>(T(0.5)), splat<R>(0));
      w[2][0] = w[2][2] = half;
      w[2][1] = T(-2) * half;
    } else {
      R phi[4], norm = splat<R>(0);
      second_mode<S>(f, w[0], phi);
      for (int k = 0; k < S::nodes; ++k) norm = norm + w[0][k] * phi[k] * phi[k];
      const R scale = T(1) / norm;
      for (int k = 0; k < S::nodes; ++k) w[2][k] = w[0][k] * phi[k] * scale;
    }
  }
};

// The MLS force -V0 D^-1 tau (Hu et al. 2018), per cell: the matrix that multiplies w (x_i - x_p) / dx.
template <class R>
NEVE_INLINE Mat3<R> mls_force(const Sym3<R>& tau, R V0, const CellScales<scalar_t<R>>& cells) {
  return scaled(full(tau), V0 * -cells.affine);
}

// The classic force -V0 tau, per cell: the matrix that multiplies dx grad w.
template <class R>
NEVE_INLINE Mat3<R> gradient_force(const Sym3<R>& tau, R V0, const CellScales<scalar_t<R>>& cells) {
  return scaled(full(tau), V0 * -cells.gradient);
}

}  // namespace neve
