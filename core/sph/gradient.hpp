// The gradient of a velocity, and the divergence of a stress (Gissler et al. 2020, equations 15 to 18).
#pragma once

#include <cstring>

#include "cpu/fields.hpp"
#include "sph/pairs.hpp"

namespace neve {

namespace detail {

// The four numbers of one row, as a pack: sums over neighbours go on row by row, without turning rows into lanes.
template <class T>
using Four = Wide<T, 4>;
template <class T>
NEVE_INLINE Four<T> four_at(const Quartet<T>& q) {
  Four<T> out;
  std::memcpy(&out, &q, sizeof(out));
  return out;
}

// sum_j q_j g_j^T over the entries of particle p: column c of the three is in sums[c]. Entries are taken two by two, in order.
template <class T>
NEVE_INLINE void sum_outer(const SphPairs<T>& snow, const Quartet<T>* rows, std::size_t p,
                           Four<T> (&sums)[3]) {
  Four<T> even[3]{}, odd[3]{};
  const std::uint32_t end = snow.own_end(p);
  std::uint32_t e = snow.begin[p];
  for (; e + 1 < end; e += 2) {
    const Four<T> a = four_at(rows[snow.row[e]]), b = four_at(rows[snow.row[e + 1]]);
    for (int c = 0; c < 3; ++c) {
      even[c] = even[c] + a * snow.gradient[c][e];
      odd[c] = odd[c] + b * snow.gradient[c][e + 1];
    }
  }
  if (e < end) {
    const Four<T> a = four_at(rows[snow.row[e]]);
    for (int c = 0; c < 3; ++c) even[c] = even[c] + a * snow.gradient[c][e];
  }
  for (int c = 0; c < 3; ++c) sums[c] = even[c] + odd[c];
}

// sum_j Q_j g_j of matrices whose columns are in three rows each.
template <class T>
NEVE_INLINE Four<T> sum_products(const SphPairs<T>& snow, const Quartet<T>* rows, std::size_t p) {
  Four<T> even[3]{}, odd[3]{};
  const std::uint32_t end = snow.own_end(p);
  std::uint32_t e = snow.begin[p];
  for (; e + 1 < end; e += 2) {
    const Quartet<T>*a = rows + 3 * std::size_t(snow.row[e]), *b = rows + 3 * std::size_t(snow.row[e + 1]);
    for (int c = 0; c < 3; ++c) {
      even[c] = even[c] + four_at(a[c]) * snow.gradient[c][e];
      odd[c] = odd[c] + four_at(b[c]) * snow.gradient[c][e + 1];
    }
  }
  if (e < end) {
    const Quartet<T>* a = rows + 3 * std::size_t(snow.row[e]);
    for (int c = 0; c < 3; ++c) even[c] = even[c] + four_at(a[c]) * snow.gradient[c][e];
  }
  return ((even[0] + odd[0]) + (even[1] + odd[1])) + (even[2] + odd[2]);
}

}  // namespace detail

// Call f(p, count, D) for packs of the particles, of `count` from p on, with
//
//   D = Dc + (tr D_s + tr D_b - tr Dc) / 3,
//   D_s = sum_j (u_j - u_i) V_j grad W_ij^T,   D_b = sum_b (u_b - u_i) V_b grad W_ib^T,   Dc = P D_s L^T:
//
// rotation and deviator by the corrected gradient of the snow alone, the change of volume by that of the pressure solve.
// P = L A is 1 where the moment A of the snow is inverted as it is; where it is not, P A L^T P^T is symmetric, so that a
// rotation strains nothing there either. `quads` hold V u of the snow, u(p, count) is u itself; at_walls(p, count):
// sum_b V_b u_b . grad W_ib over the boundaries whose sum of V_b grad W_ib is `walls`.
template <class T, class U, class A, class F>
void each_gradient(const SphPairs<T>& snow, const SphSums<T>& sums, std::size_t n, const Field<T, 3>& walls,
                   U&& u, A&& at_walls, F&& f) {
  using R = Lanes<T>;
  each_rows_together(n, [&](std::size_t begin, std::size_t end) {
    alignas(64) T D_s[9][rows_together];
    for (std::size_t p = begin; p < end; ++p) {
      detail::Four<T> columns[3];
      detail::sum_outer(snow, sums.quads.data(), p, columns);
      for (int k = 0; k < 9; ++k) D_s[k][p - begin] = columns[k / 3][k % 3];
    }
    for (std::size_t p = begin; p < end; p += width<R>) {
      const int count = int(std::min<std::size_t>(width<R>, end - p));
      const Vec3<R> here = u(p, count), around = load_vector<R>(sums.around, p, count);
      Mat3<R> own;
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r)
          own(r, c) = load<R>(D_s[3 * c + r] + (p - begin), count) - here[r] * around[c];
      }
      Mat3<R> D = load_matrix<R>(sums.P, p, count) * (own * load_matrix<R>(sums.L, p, count));
      const R volume =
          own(0, 0) + own(1, 1) + own(2, 2) + at_walls(p, count) - dot(here, load_vector<R>(walls, p, count));
      const R rest = (volume - (D(0, 0) + D(1, 1) + D(2, 2))) * T(1.0 / 3);
      for (int k = 0; k < 3; ++k) D(k, k) = D(k, k) + rest;
      f(p, count, D);
    }
  });
}

// Prepare what `each_divergence` gathers, V Q, of symmetric stresses s in `sums.s`: Q = tr s / 3 + P dev s L, for which
// s : D[u] = Q : D_s + tr s / 3 tr D_b. So the forces do the work of the stress on the strain that they make.
template <class T>
void fill_stress_rows(std::size_t n, SphSums<T>& sums) {
  using R = Lanes<T>;
  each_pack<T>(n, [&](std::size_t p, int count) {
    const R V = load<R>(sums.V.column(0) + p, count);
    Sym3<R> s = load_symmetric<R>(sums.s, p, count);
    const R third = (s.xx + s.yy + s.zz) * T(1.0 / 3);
    s.xx = s.xx - third, s.yy = s.yy - third, s.zz = s.zz - third;
    Mat3<R> Q = load_matrix<R>(sums.P, p, count) * (full(s) * load_matrix<R>(sums.L, p, count));
    for (int k = 0; k < 3; ++k) Q(k, k) = Q(k, k) + third;
    for (int c = 0; c < 3; ++c) store_rows(Q.column(c) * V, sums.row.data(), p, count, 3, c);
  });
}

// Call f(p, count, div) for packs of the particles with div_i = sum_j V_j (Q_i + Q_j) grad W_ij + tr s_i / 3 sum_b V_b grad W_ib
// [Pa/m], over the boundaries of `held`.
template <class T, class F>
void each_divergence(const SphPairs<T>& snow, const SphSums<T>& sums, std::size_t n, F&& f) {
  using R = Lanes<T>;
  each_rows_together(n, [&](std::size_t begin, std::size_t end) {
    alignas(64) T sum[3][rows_together];
    for (std::size_t p = begin; p < end; ++p) {
      detail::Four<T> total = detail::sum_products(snow, sums.row.data(), p), own{};
      for (int c = 0; c < 3; ++c)
        own = own + detail::four_at(sums.row[3 * p + std::size_t(c)]) * sums.around.column(c)[p];
      total = total + own * (T(1) / sums.V.column(0)[p]);
      for (int k = 0; k < 3; ++k) sum[k][p - begin] = total[k];
    }
    for (std::size_t p = begin; p < end; p += width<R>) {
      const int count = int(std::min<std::size_t>(width<R>, end - p));
      const R trace = load<R>(sums.s.column(0) + p, count) + load<R>(sums.s.column(1) + p, count) +
                      load<R>(sums.s.column(2) + p, count);
      Vec3<R> div = load_vector<R>(sums.held, p, count) * R(trace * T(1.0 / 3));
      for (int k = 0; k < 3; ++k) div[k] = div[k] + load<R>(sum[k] + (p - begin), count);
      f(p, count, div);
    }
  });
}

}  // namespace neve
