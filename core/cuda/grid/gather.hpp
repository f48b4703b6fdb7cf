// From the nodes of a tile to one particle.
#pragma once

#include "cuda/grid/stencil.hpp"
#include "cuda/grid/tile.hpp"

namespace neve::cuda {

// For each of the first `Modes` modes, the sum over the nodes of x_a y_b z_c u. Sums over z first, then y, then x: the
// products of weights are not made node by node.
template <int Modes, class T, class Spline, class Weights>
NEVE_INLINE void gather(const Quad<T>* tile, const Stencil<T, Spline, Weights>& at, Vec3<T> (&sum)[Modes]) {
  constexpr int K = Spline::nodes, Q = Modes == 1 ? 1 : Weights::count;
  constexpr auto& order = modes_of<(Weights::count > 2 ? 3 : 2)>;
  // with four modes only one degree is above 0
  const auto used = [](int b, int c) { return Modes != 4 || b + c < 2; };
  for (Vec3<T>& a : sum) a = Vec3<T>{};
  const Quad<T>* corner = tile + at.first;
  NEVE_UNROLL
  for (int i = 0; i < K; ++i) {
    Vec3<T> plane[Q][Q] = {};
    NEVE_UNROLL
    for (int j = 0; j < K; ++j) {
      Vec3<T> row[Q] = {};
      NEVE_UNROLL
      for (int k = 0; k < K; ++k) {
        const Quad<T>& u = corner[node_after(i, j, k)];
        for (int c = 0; c < Q; ++c) row[c] = row[c] + Vec3<T>{u.x, u.y, u.z} * at.w[2][c][k];
      }
      for (int b = 0; b < Q; ++b) {
        for (int c = 0; c < Q; ++c) {
          if (used(b, c)) plane[b][c] = plane[b][c] + row[c] * at.w[1][b][j];
        }
      }
    }
    NEVE_UNROLL
    for (int n = 0; n < Modes; ++n) {
      const int* d = order[n].degree;
      sum[n] = sum[n] + plane[d[1]][d[2]] * at.w[0][d[0]][i];
    }
  }
}

}  // namespace neve::cuda
