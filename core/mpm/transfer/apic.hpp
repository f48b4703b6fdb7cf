// APIC (Jiang et al. 2015) with the MLS-MPM stress (Hu et al. 2018): the affine velocity C travels with the particle,
// grad v := C, and the force rides on the momentum. Conserves linear and angular momentum.
//
//   (m v)_i = sum_p w_ip [ m_p v_p + (m_p C_p - dt V0_p D^-1 tau_p) (x_i - x_p) ],   C_p = D^-1 sum_i w_ip v_i (x_i - x_p)^T
#pragma once

#include "mpm/model.hpp"
#include "mpm/state.hpp"

namespace neve {

struct Apic {
  static constexpr bool has_change = false;

  template <class S, class R>
  static void second_weights(R f, const R* w, const R*, R* s) {
    for (int k = 0; k < S::nodes; ++k) s[k] = w[k] * S::template offset<R>(f, k);
  }

  // The matrix A of the scatter, per cell: columns multiply the axes of x_i - x_p.
  template <class S, class R>
  static Mat3<R> affine_momentum(const State<scalar_t<R>>& state, std::size_t p, int count, double dx,
                                 double dt, R m, R V0) {
    using T = scalar_t<R>;
    const R k = V0 * T(-dt * S::inverse_inertia / dx);
    return scaled(load_matrix<R>(state.C, p, count), m * T(dx)) +
           scaled(full(load_symmetric<R>(state.tau, p, count)), k);
  }

  // From the gathered G = sum w v_i (x_i - x_p)^T / dx: the velocity gradient, which is C.
  template <class S, class R>
  static Mat3<R> velocity_gradient(const Mat3<R>& G, double dx) {
    return scaled(G, scalar_t<R>(S::inverse_inertia / dx));
  }

  // v_p = v_PIC: the affine part holds the rest.
  template <class R>
  static Vec3<R> velocity(const Vec3<R>&, const Vec3<R>& pic, const Vec3<R>&, double) {
    return pic;
  }

  template <class R>
  static void keep(State<scalar_t<R>>& state, std::size_t p, int count, const Mat3<R>& C) {
    store_matrix(state.C, p, C, count);
  }
};

}  // namespace neve
