// From particles to the nodes of a tile.
#pragma once

#include "cpu/grid/stencil.hpp"

namespace neve {

namespace detail {

// a + k b, for k from -1 to 2.
template <class R>
NEVE_INLINE R plus_times(const R& a, int k, const R& b) {
  return k == 0 ? a : k < 0 ? R(a - b) : k == 1 ? R(a + b) : R(a + (b + b));
}

}  // namespace detail

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
  template <int Q>
  NEVE_INLINE void add(const Stencils<T, S, Q>& st, int l, Row<T> q) {
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

  // The same where A multiplies the whole numbers.
  NEVE_INLINE void add(const Stencils<T, S, 1>& st, int l, Row<T> q, Row<T> ax, Row<T> ay, Row<T> az) {
    const Row<T> wz = row_of_weights(st.z[0] + 4 * l);
    const Row<T> p = wz * (q + whole_offsets<T>() * az), px = wz * ax, py = wz * ay;
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      const T x = st.x[0][i][l];
      const Row<T> r = detail::plus_times(p, i - 1, px) * x, y = py * x;
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) sum_[i][j] += st.y[0][j][l] * detail::plus_times(r, j - 1, y);
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
        p[ab / Q][ab % Q] += z * row_of_quad(mode[mode_places<Q>[ab * Q + c]] + 4 * l);
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

}  // namespace neve
