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

// Particles made ready for the scatter of w q + g . A with g = w (x_i - x_p).
template <class T, class S, int N>
struct AffineBatch {
  static constexpr int K = S::nodes, capacity = N;
  alignas(64) T xy[K][K][N];         // products of the weights along x and y
  alignas(64) T z[4 * N];            // quads per particle, zero-padded
  alignas(64) T q[4 * N];            // what A does of the way to the second node is part of it
  alignas(64) T a[3][4 * N];         // rows of A
  alignas(64) std::int32_t cell[N];  // index of the stencil's first value in the tile

  // The weights of the particles from `first` on.
  template <class R>
  NEVE_INLINE Vec3<R> place(int first, const TileFrame<T>& frame, const Vec3<R>& way) {
    R w[3][1][4];
    Vec3<R> shift;
    const R index = detail::place<S, SplineWeights>(frame, way, w, shift);
    for (int i = 0; i < K; ++i) {
      for (int j = 0; j < K; ++j) store(xy[i][j] + first, R(w[0][0][i] * w[1][0][j]));
    }
    if constexpr (K == 3) w[2][0][3] = splat<R>(0);
    store_quads(z + 4 * first, w[2][0][0], w[2][0][1], w[2][0][2], w[2][0][3]);
    store_integers(cell + first, index);
    return shift;
  }

  // What they give.
  template <class R>
  NEVE_INLINE void give(int first, const Vec3<R>& momentum, const R& mass, const Mat3<R>& A,
                        const Vec3<R>& shift) {
    const R zero = splat<R>(0);
    const Vec3<R> all = momentum + A * shift;
    store_quads(q + 4 * first, all.x, all.y, all.z, mass);
    for (int k = 0; k < 3; ++k)
      store_quads(a[k] + 4 * first, A.column(k).x, A.column(k).y, A.column(k).z, zero);
  }
};

namespace detail {

// Add the particles [begin, end) of one cell to the tile: of each row the register Part, of the rows i those from First on.
// Their sums stay in registers, of which AVX2 has no more than that.
template <int Part, int First, int Rows, class T, class S, int N>
NEVE_INLINE void scatter_part(const AffineBatch<T, S, N>& of, int begin, int end, T* corner) {
  constexpr int K = S::nodes;
  Register<T> sum[Rows][K] = {};
  for (int l = begin; l < end; ++l) {
    const Register<T> w = part_of_weights(of.z + 4 * l, Part);
    const Register<T> p =
        rounded(w * (part_of_quads(of.q + 4 * l, Part) +
                     part_of(whole_offsets<T>(), Part) * part_of_quads(of.a[2] + 4 * l, Part)));
    const Register<T> px = rounded(w * part_of_quads(of.a[0] + 4 * l, Part)),
                      py = rounded(w * part_of_quads(of.a[1] + 4 * l, Part));
    for_parts<Rows>([&](int i) NEVE_INLINE_LAMBDA {
      const Register<T> r = plus_times(p, First + i - 1, px);
      for_parts<K>(
          [&](int j) NEVE_INLINE_LAMBDA { sum[i][j] += of.xy[First + i][j][l] * plus_times(r, j - 1, py); });
    });
  }
  for_parts<Rows>([&](int i) NEVE_INLINE_LAMBDA {
    for_parts<K>([&](int j) NEVE_INLINE_LAMBDA {
      T* row = corner + row_offset(First + i, j) + Part * register_lanes<T>;
      store(row, load<Register<T>>(row) + sum[i][j]);
    });
  });
}

}  // namespace detail

// Add the first `count` particles of a batch to the tile. Particles of one cell, being neighbours in memory, meet in registers.
template <class T, class S, int N>
void scatter(const AffineBatch<T, S, N>& of, int count, Tile<T>& tile) {
  constexpr int K = S::nodes, parts = (4 * K + register_lanes<T> - 1) / register_lanes<T>;
  constexpr int rows = K == 3 || register_bytes == 64 ? K : K / 2;
  for (int begin = 0, end; begin < count; begin = end) {
    for (end = begin + 1; end < count && of.cell[end] == of.cell[begin];) ++end;
    T* corner = tile.value + of.cell[begin];
    [&]<int... part>(std::integer_sequence<int, part...>) NEVE_INLINE_LAMBDA {
      ((detail::scatter_part<part, 0, rows>(of, begin, end, corner),
        [&] {
          if constexpr (rows < K) detail::scatter_part<part, rows, K - rows>(of, begin, end, corner);
        }()),
       ...);
    }(std::make_integer_sequence<int, parts>{});
  }
}

}  // namespace neve
