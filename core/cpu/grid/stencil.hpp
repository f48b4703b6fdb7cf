// The weights of a batch of particles, and the two row operations that all transfers are made of.
//
// A transfer carries, from each particle to each node of its stencil, the numbers
//     w_i q + g_i . A        (q: four numbers, A: a 3 x 4 matrix, one row per axis)
// and back the sums sum_i w_i u_i and sum_i g_i u_i^T. `w` are the spline's weights; `g` is the transfer's choice of
// second weights: w (x_i - x_p) for affine transfers, grad w for classic ones. Both factor over the axes,
//     g_x = s_x w_y w_z,  g_y = w_x s_y w_z,  g_z = w_x w_y s_z     (s: second weights of one axis),
// so a row of nodes in z is one vector, and x and y are two short loops around it.
//
// Where g = w (x_i - x_p), x_i - x_p in cells is a whole number, that of node i from the stencil's second node, plus `shift`,
// the way there from the particle. Then only w is stored; the whole numbers are additions of rows, and the shift is
// done for all particles of a batch at once:
//     w_i q + g_i . A = w_i ((q + shift . A) + whole_i . A)
#pragma once

#include "cpu/grid/tile.hpp"
#include "math/bspline.hpp"
#include "transfer/modes.hpp"
#include "transfer/weights.hpp"

namespace neve {

// The spline's weights alone: with the shift, all that affine transfers need.
struct SplineWeights {
  static constexpr int count = 1;
  template <class S, class R>
  NEVE_INLINE static void axis(R f, R (*w)[4]) {
    R dw[4];
    S::weights(f, w[0], dw);
  }
};
// What a batch stores of the weights W of a transfer with so many modes.
template <class W, int modes>
using StoredWeights = std::conditional_t<std::is_same_v<W, AffineWeights> && modes == 4, SplineWeights, W>;

namespace detail {

// The weights of particles along each axis, the shift from them to their second node [cells], and the index of their stencil's
// first value in the tile. `way`: from the tile's first node [m].
template <class S, class W, class T, class R>
NEVE_INLINE R place(const TileFrame<T>& frame, const Vec3<R>& way, R (*w)[W::count][4], Vec3<R>& shift) {
  R index = splat<R>(0);
  for (int a = 0; a < 3; ++a) {
    // a drifted particle is caught by g2p; the clamp keeps even a wrong call inside the tile
    const R u = clamp(frame.local(way[a]), splat<R>(0), splat<R>(T(S::reach)));
    const R base = floor(u), f = u - base;
    W::template axis<S>(f, w[a]);
    if constexpr (W::count == 1) shift[a] = S::template offset<R>(f, 1);
    index = index * T(tile_width) + base;
  }
  return index * T(4);
}

}  // namespace detail

// Weights of up to lane_count particles: for each axis the spline's [0] and the transfer's second [1] (and third).
template <class T, class S, int Q = 2>
struct Stencils {
  static constexpr int K = S::nodes, L = lane_count<T>;
  alignas(64) T x[Q][K][L], y[Q][K][L];
  alignas(64) T z[Q][4 * L];         // quads per particle, zero-padded
  alignas(64) std::int32_t cell[L];  // index of the stencil's first value in the tile
  Vec3<Lanes<T>> shift;              // from the particle to the second node [cells]

  // W gives the weights of one axis.
  template <class W>
  NEVE_INLINE void fill(const TileFrame<T>& frame, const Vec3<Lanes<T>>& way) {
    static_assert(W::count == Q);
    using R = Lanes<T>;
    R w[3][Q][4];
    const R index = detail::place<S, W>(frame, way, w, shift);
    for (int q = 0; q < Q; ++q) {
      for (int k = 0; k < K; ++k) store(x[q][k], w[0][q][k]), store(y[q][k], w[1][q][k]);
      if constexpr (K == 3) w[2][q][3] = splat<R>(0);
      store_quads(z[q], w[2][q][0], w[2][q][1], w[2][q][2], w[2][q][3]);
    }
    store_integers(cell, index);
  }
};

// The whole numbers of the four nodes of a row, for each of a node's four numbers.
template <class T>
NEVE_INLINE Row<T> whole_offsets() {
  alignas(64) static constexpr T k[16] = {-1, -1, -1, -1, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2};
  return load_row<T>(k);
}

// Offset in the tile of the stencil's row (i, j).
inline constexpr int row_offset(int i, int j) { return (i * tile_width + j) * tile_width * 4; }

}  // namespace neve
