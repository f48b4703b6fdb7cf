// Where a particle is in its home's tile, and the weights of its nodes.
#pragma once

#include "cuda/grid/views.hpp"
#include "transfer/modes.hpp"
#include "transfer/weights.hpp"

namespace neve::cuda {

// The place of a home's tile in units of cells: s = x / dx - shift - 4 block.
template <class T>
struct TileFrame {
  T per_dx;
  T origin[3];

  template <class Spline>
  NEVE_INLINE static TileFrame of(const StepConstants<T>& step, const BlockCoord& at) {
    constexpr T shift = T(Spline::shift);
    return {step.cells.gradient, {T(4 * at.x) + shift, T(4 * at.y) + shift, T(4 * at.z) + shift}};
  }
  NEVE_INLINE T local(T x, int axis) const { return x * per_dx - origin[axis]; }
};

// The weights of each axis and kind at the nodes, and the tile's node that is the stencil's first.
template <class T, class Spline, class Weights>
struct Stencil {
  T w[3][Weights::count][Spline::nodes];
  int first;

  NEVE_INLINE void fill(const TileFrame<T>& frame, const Vec3<T>& x) {
    first = 0;
    for (int a = 0; a < 3; ++a) {
      // a drifted particle is caught by g2p; the clamp keeps even a wrong call inside the tile
      const T u = clamp(frame.local(x[a], a), T(0), T(Spline::reach));
      const T base = floor(u);
      T all[Weights::count][4];
      Weights::template axis<Spline>(T(u - base), all);
      for (int q = 0; q < Weights::count; ++q) {
        for (int k = 0; k < Spline::nodes; ++k) w[a][q][k] = all[q][k];
      }
      first = first * tile_side + int(base);
    }
  }
};

// The tile's node (i, j, k) after the stencil's first.
NEVE_INLINE int node_after(int i, int j, int k) { return (i * tile_side + j) * tile_side + k; }

}  // namespace neve::cuda
