// The weights of a batch of particles, and the two row operations that all transfers are made of.
//
// A transfer carries, from each particle to each node of its stencil, the numbers
//     w_i q + g_i . A        (q: four numbers, A: a 3 x 4 matrix, one row per axis)
// and back the sums sum_i w_i u_i and sum_i g_i u_i^T. `w` are the spline's weights; `g` is the transfer's choice of
// second weights: w (x_i - x_p) for affine transfers, grad w for classic ones. Both factor over the axes,
//     g_x = s_x w_y w_z,  g_y = w_x s_y w_z,  g_z = w_x w_y s_z     (s: second weights of one axis),
// so a row of nodes in z is one vector, and x and y are two short loops around it.
#pragma once

#include "cpu/grid/tile.hpp"
#include "math/bspline.hpp"
#include "transfer/modes.hpp"

namespace neve {

// Weights of up to lane_count particles: for each axis the spline's [0] and the transfer's second [1] (and third).
template <class T, class S, int Q = 2>
struct Stencils {
  static constexpr int K = S::nodes, L = lane_count<T>;
  alignas(64) T x[Q][K][L], y[Q][K][L];
  alignas(64) T z[Q][4 * L];         // quads per particle, zero-padded
  alignas(64) std::int32_t cell[L];  // index of the stencil's first value in the tile

  // W gives the weights of one axis.
  template <class W>
  NEVE_INLINE void fill(const TileFrame<T>& frame, const Vec3<Lanes<T>>& at) {
    static_assert(W::count == Q);
    using R = Lanes<T>;
    R w[3][Q][4];
    R index = splat<R>(0);
    for (int a = 0; a < 3; ++a) {
      // a drifted particle is caught by g2p; the clamp keeps even a wrong call inside the tile
      const R u = clamp(frame.local(at[a], a), splat<R>(0), splat<R>(T(S::reach)));
      const R base = floor(u), f = u - base;
      W::template axis<S>(f, w[a]);
      index = index * T(tile_width) + base;
    }
    for (int q = 0; q < Q; ++q) {
      for (int k = 0; k < K; ++k) store(x[q][k], w[0][q][k]), store(y[q][k], w[1][q][k]);
      if constexpr (K == 3) w[2][q][3] = splat<R>(0);
      store_quads(z[q], w[2][q][0], w[2][q][1], w[2][q][2], w[2][q][3]);
    }
    store_integers(cell, R(index * T(4)));
  }
};

// Offset in the tile of the stencil's row (i, j).
inline constexpr int row_offset(int i, int j) { return (i * tile_width + j) * tile_width * 4; }

}  // namespace neve
