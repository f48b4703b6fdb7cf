// From the nodes of a tile to particles.
#pragma once

#include "cpu/grid/stencil.hpp"

namespace neve {

// Reads sums over a stencil from the tile.
template <class T, class S>
class Gather {
 public:
  explicit Gather(const Tile<T>& tile) : tile_(tile.value) {}

  // Four rows, whose nodes add up to the quads sum w u, sum g_x u, sum g_y u, sum g_z u, of lane l.
  NEVE_INLINE void rows(const Stencils<T, S>& st, int l, Row<T> (&out)[4]) const {
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
    out[0] = wz * a, out[1] = wz * ax, out[2] = wz * ay, out[3] = sz * a;
  }

  // The same with the whole numbers in place of x_i - x_p.
  NEVE_INLINE void rows(const Stencils<T, S, 1>& st, int l, Row<T> (&out)[4]) const {
    const T* corner = tile_ + st.cell[l];
    Row<T> a[4], ay{};
#pragma GCC unroll 4
    for (int i = 0; i < S::nodes; ++i) {
      Row<T> u[4];
#pragma GCC unroll 4
      for (int j = 0; j < S::nodes; ++j) u[j] = st.y[0][j][l] * load_row<T>(corner + row_offset(i, j));
      a[i] = st.x[0][i][l] * sum(u);
      ay += st.x[0][i][l] * first_moment(u);
    }
    const Row<T> wz = row_of_weights(st.z[0] + 4 * l);
    out[0] = wz * sum(a), out[1] = wz * first_moment(a), out[2] = wz * ay;
    out[3] = whole_offsets<T>() * out[0];
  }

  // Their sums, four quads of each of the first `count` lanes, into to[0..3] + 4 l.
  template <int Q>
  NEVE_INLINE void affine(const Stencils<T, S, Q>& st, int count, T (*to)[4 * lane_count<T>]) const {
    if constexpr (Q == 1 && register_bytes < 64 && detail::RowShape<T>::quads > 0) {
      by_parts(st, count, to);
    } else {
      groups(st, count, to);
    }
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
      const int* d = modes_of<Q>[n].degree;
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
  // Where a row is one register, four lanes at a time: then whole rows are written.
  template <int Q>
  NEVE_INLINE void groups(const Stencils<T, S, Q>& st, int count, T (*to)[4 * lane_count<T>]) const {
    constexpr int together = register_count<Row<T>> == 1 ? 4 : 1;
    for (int l = 0; l < count; l += together) {
      Row<T> of[together][4];
#pragma GCC unroll 4
      for (int k = 0; k < together; ++k) rows(st, l + k, of[k]);
      if constexpr (together == 4) {
#pragma GCC unroll 4
        for (int n = 0; n < 4; ++n)
          store_row<T>(to[n] + 4 * l, sum_nodes<T>(of[0][n], of[1][n], of[2][n], of[3][n]));
      } else {
        const Row<T> s = sum_nodes<T>(of[0][0], of[0][1], of[0][2], of[0][3]);
        for (int n = 0; n < 4; ++n) store_quad<T>(to[n] + 4 * l, s, n);
      }
    }
  }

  // Where a row is several registers of whole quads, one after the other, so that all stays in sixteen of them.
  NEVE_INLINE void by_parts(const Stencils<T, S, 1>& st, int count, T (*to)[4 * lane_count<T>]) const {
    for (int l = 0; l < count; ++l) {
      Register<T> of[4];
      sums_of_parts(st, l, of);
      for_parts<4>([&](int n) NEVE_INLINE_LAMBDA {
        if constexpr (register_lanes<T> == 4) {
          store(to[n] + 4 * l, of[n]);
        } else if (n % 2 == 0) {
          constexpr auto seq = std::make_index_sequence<8>{};
          const Register<T> two =
              detail::halves<false>(of[n], of[n + 1], seq) + detail::halves<true>(of[n], of[n + 1], seq);
          store_quad<T>(to[n] + 4 * l, {two, two}, 0), store_quad<T>(to[n + 1] + 4 * l, {two, two}, 1);
        }
      });
    }
  }

  // The four rows of lane l, each as the sum of its registers, but for those without weight.
  NEVE_INLINE void sums_of_parts(const Stencils<T, S, 1>& st, int l, Register<T> (&out)[4]) const {
    using P = Register<T>;
    constexpr int parts = (4 * S::nodes + register_lanes<T> - 1) / register_lanes<T>;
    const T* corner = tile_ + st.cell[l];
    for_parts<parts>([&](int part) NEVE_INLINE_LAMBDA {
      P a[4], ay[4];
      for_parts<S::nodes>([&](int i) NEVE_INLINE_LAMBDA {
        P u[4];
        for_parts<S::nodes>([&](int j) NEVE_INLINE_LAMBDA {
          u[j] = st.y[0][j][l] * load<P>(corner + row_offset(i, j) + part * register_lanes<T>);
          if (j != 1) u[j] = rounded(u[j]);
        });
        a[i] = st.x[0][i][l] * sum(u);
        if (i != 1) a[i] = rounded(a[i]);
        ay[i] = st.x[0][i][l] * first_moment(u);
      });
      const P w = part_of_weights(st.z[0] + 4 * l, part), all = rounded(w * sum(a));
      const P of[4] = {all, w * first_moment(a), w * sum(ay), part_of(whole_offsets<T>(), part) * all};
      for (int n = 0; n < 4; ++n) out[n] = part == 0 ? of[n] : out[n] + of[n];
    });
  }

  template <class P>
  NEVE_INLINE static P sum(const P (&u)[4]) {
    const P three = u[0] + u[2] + u[1];
    if constexpr (S::nodes == 3) return three;
    return three + u[3];
  }
  template <class P>
  NEVE_INLINE static P first_moment(const P (&u)[4]) {
    const P three = u[2] - u[0];
    if constexpr (S::nodes == 3) return three;
    return three + (u[3] + u[3]);
  }

  const T* tile_;
};

}  // namespace neve
