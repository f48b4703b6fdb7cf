// The weights of a batch of particles, and the two row operations that all transfers are made of.
//
// A transfer carries, from each particle to each node of its stencil, the numbers
//     w_i q + g_i . A        (q: four numbers, A: a 3 x 4 matrix, one row per axis)
// and back the sums sum_i w_i u_i and sum_i g_i u_i^T. `w` are the spline's weights; `g` is the transfer's choice of
// second weights: w (x_i - x_p) for affine transfers, grad w for classic ones. Both factor over the axes,
//     g_x = s_x w_y w_z,  g_y = w_x s_y w_z,  g_z = w_x w_y s_z     (s: second weights of one axis),
// so a row of nodes in z is one vector, and x and y are two short loops around it.
#pragma once

#include "grid/blocks.hpp"
#include "math/bspline.hpp"
#include "math/rows.hpp"
#include "mpm/modes.hpp"

namespace neve {

inline constexpr int tile_width = 8;
inline constexpr int tile_values = tile_width * tile_width * tile_width * 4;

// A home's 8x8x8 nodes; one row of slack, since a row operation reads and writes four nodes for a stencil of three.
template <class T>
struct Tile {
  alignas(64) T value[tile_values + 16];

  void clear() { std::memset(value, 0, sizeof(value)); }
  // Call f(pointer into the tile, pointer into the node block) for each row of four nodes.
  template <class F>
  void each_row(const Home& home, F&& f, T* (Grid<T>::*block)(std::int32_t), Grid<T>& grid) {
    for (int k = 0; k < 8; ++k) {
      T* nodes = (grid.*block)(home.nodes[static_cast<std::size_t>(k)]);
      T* corner = value + (((k >> 2) * 4 * tile_width + ((k >> 1) & 1) * 4) * tile_width + (k & 1) * 4) * 4;
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j)
          f(corner + (i * tile_width + j) * tile_width * 4, nodes + (i * 4 + j) * 16);
      }
    }
  }
  void load_from(Grid<T>& grid, const Home& home, T* (Grid<T>::*block)(std::int32_t)) {
    each_row(home, [](T* mine, T* theirs) { std::memcpy(mine, theirs, 16 * sizeof(T)); }, block, grid);
    std::memset(value + tile_values, 0, 16 * sizeof(T));
  }
  void add_to(Grid<T>& grid, const Home& home, T* (Grid<T>::*block)(std::int32_t)) {
    const auto add = [](T* mine, T* theirs) {
      store_row<T>(theirs, load_row<T>(theirs) + load_row<T>(mine));
    };
    each_row(home, add, block, grid);
  }
};

// The place of a home's tile in units of cells: s = x inv_dx - shift - 4 block.
template <class T>
struct TileFrame {
  T inv_dx;
  T origin[3];

  template <class S>
  static TileFrame of(double dx, BlockCoord at) {
    return {T(1 / dx), {T(4 * at.x) + T(S::shift), T(4 * at.y) + T(S::shift), T(4 * at.z) + T(S::shift)}};
  }
  template <class R>
  R local(R x, int axis) const {
    return x * inv_dx - origin[axis];
  }
};

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

// Sums particles into the tile; particles of one cell, being neighbours in memory, meet in registers.
template <class T, class S>
class Scatter {
 public:
  explicit Scatter(Tile<T>& tile) : tile_(tile.value) {}

  void move_to(int cell) {
    if (cell == cell_) return;
    flush();
    cell_ = cell;
  }

  // Add w q of the batch's lane l.
  NEVE_INLINE void add(const Stencils<T, S>& st, int l, Row<T> q) {
    const Row<T> p = row_of_weights(st.z[0] + 4 * l) * q;
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      const Row<T> r = st.x[0][i][l] * p;
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) sum_[i][j] += st.y[0][j][l] * r;
    }
  }

  // Add w q + g . A, with the rows ax, ay, az of A.
  NEVE_INLINE void add(const Stencils<T, S>& st, int l, Row<T> q, Row<T> ax, Row<T> ay, Row<T> az) {
    const Row<T> wz = row_of_weights(st.z[0] + 4 * l), sz = row_of_weights(st.z[1] + 4 * l);
    const Row<T> p = wz * q + sz * az, px = wz * ax, py = wz * ay;
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      const Row<T> r = st.x[0][i][l] * p + st.x[1][i][l] * px, y = st.x[0][i][l] * py;
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j)
        sum_[i][j] = (sum_[i][j] + st.y[0][j][l] * r) + st.y[1][j][l] * y;  // two fused multiply-adds
    }
  }

  // Add the modes' sum, over a b c, of x_a y_b z_c q_abc: quads of lane l in the order of modes.hpp, axis by axis.
  template <int Q>
  NEVE_INLINE void add(const Stencils<T, S, Q>& st, int l, const T (*mode)[4 * lane_count<T>]) {
    Row<T> p[Q][Q] = {};
#pragma GCC unroll 3
    for (int c = 0; c < Q; ++c) {
      const Row<T> z = row_of_weights(st.z[c] + 4 * l);
#pragma GCC unroll 9
      for (int ab = 0; ab < Q * Q; ++ab)
        p[ab / Q][ab % Q] += z * row_of_quad(mode[mode_places<Q>[std::size_t(ab * Q + c)]] + 4 * l);
    }
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      Row<T> r[Q] = {};
#pragma GCC unroll 9
      for (int ab = 0; ab < Q * Q; ++ab) r[ab % Q] += st.x[ab / Q][i][l] * p[ab / Q][ab % Q];
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) {
#pragma GCC unroll 3
        for (int b = 0; b < Q; ++b) sum_[i][j] += st.y[b][j][l] * r[b];
      }
    }
  }

  void flush() {
    if (cell_ < 0) return;
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) {
        T* row = tile_ + cell_ + row_offset(i, j);
        store_row<T>(row, load_row<T>(row) + sum_[i][j]);
        sum_[i][j] = Row<T>{};
      }
    }
    cell_ = -1;
  }

 private:
  T* tile_;
  int cell_ = -1;
  Row<T> sum_[S::nodes][S::nodes] = {};
};

// Reads sums over a stencil from the tile.
template <class T, class S>
class Gather {
 public:
  explicit Gather(const Tile<T>& tile) : tile_(tile.value) {}

  // Four quads: sum w u, sum g_x u, sum g_y u, sum g_z u, of lane l.
  NEVE_INLINE Row<T> sums(const Stencils<T, S>& st, int l) const {
    const T* corner = tile_ + st.cell[l];
    Row<T> a{}, ax{}, ay{};
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      Row<T> r{}, ry{};
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) {
        const Row<T> u = load_row<T>(corner + row_offset(i, j));
        r += st.y[0][j][l] * u;
        ry += st.y[1][j][l] * u;
      }
      a += st.x[0][i][l] * r;
      ax += st.x[1][i][l] * r;
      ay += st.x[0][i][l] * ry;
    }
    const Row<T> wz = row_of_weights(st.z[0] + 4 * l), sz = row_of_weights(st.z[1] + 4 * l);
    return sum_nodes<T>(wz * a, wz * ax, wz * ay, sz * a);
  }

  // For each mode, in the order of modes.hpp, the quad sum x_a y_b z_c u of lane l, into sum[mode] + 4 l.
  template <int Q>
  NEVE_INLINE void modes(const Stencils<T, S, Q>& st, int l, T (*sum)[4 * lane_count<T>]) const {
    const T* corner = tile_ + st.cell[l];
    Row<T> p[Q][Q] = {};
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      Row<T> r[Q] = {};
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) {
        const Row<T> u = load_row<T>(corner + row_offset(i, j));
#pragma GCC unroll 3
        for (int b = 0; b < Q; ++b) r[b] += st.y[b][j][l] * u;
      }
#pragma GCC unroll 9
      for (int ab = 0; ab < Q * Q; ++ab) p[ab / Q][ab % Q] += st.x[ab / Q][i][l] * r[ab % Q];
    }
    const auto of = [&](int n) {
      if (n >= Q * Q * Q) return Row<T>{};
      const int* d = modes_of<Q>[static_cast<std::size_t>(n)].degree;
      return row_of_weights(st.z[d[2]] + 4 * l) * p[d[0]][d[1]];
    };
    for (int n = 0; n < Q * Q * Q; n += 4) {
      const Row<T> s = sum_nodes<T>(of(n), of(n + 1), of(n + 2), of(n + 3));
      for (int k = 0; k < std::min(4, Q * Q * Q - n); ++k) store_quad<T>(sum[n + k] + 4 * l, s, k);
    }
  }

  // The quad sum w u alone.
  template <int Q>
  NEVE_INLINE Row<T> sum(const Stencils<T, S, Q>& st, int l) const {
    const T* corner = tile_ + st.cell[l];
    Row<T> a{};
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      Row<T> r{};
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) r += st.y[0][j][l] * load_row<T>(corner + row_offset(i, j));
      a += st.x[0][i][l] * r;
    }
    a *= row_of_weights(st.z[0] + 4 * l);
    return sum_nodes<T>(a, a, a, a);
  }

 private:
  const T* tile_;
};

}  // namespace neve
