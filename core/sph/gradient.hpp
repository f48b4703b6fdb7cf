// The gradient of a velocity, and the divergence of a stress (Gissler et al. 2020, equations 15 to 18).
#pragma once

#include "sph/pairs.hpp"

namespace neve {

// D = Dc + (tr D_s + tr D_b - tr Dc) / 3, with
//
//   D_s = sum_j (u_j - u_i) V_j grad W_ij^T,   D_b = sum_b (u_b - u_i) V_b grad W_ib^T,   Dc = D_s L^T:
//
// rotation and deviator by the corrected gradient, the change of volume by that of the pressure solve. `quads` hold V u of
// the snow; at_walls: sum_b V_b u_b . grad W_ib.
template <class T>
Mat3<T> velocity_gradient(const SphPairs<T>& snow, const SphSums<T>& sums, const Vec3<T>& u, T at_walls,
                          std::size_t p) {
  using R = Lanes<T>;
  T sum[9];
  snow.sum(p, sum, [&](std::uint32_t e, int count, R(&out)[9]) {
    const auto q = gather_quartets<R>(sums.quads.data(), snow.row.data() + e);
    const Vec3<R> g = snow.template slope<R>(e, count);
    for (int c = 0; c < 3; ++c)
      out[3 * c] += q.a * g[c], out[3 * c + 1] += q.b * g[c], out[3 * c + 2] += q.c * g[c];
  });
  const Vec3<T> around = vector_at(sums.around, p);
  Mat3<T> D_s;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) D_s(r, c) = sum[3 * c + r] - u[r] * around[c];
  }
  const Mat3<T> L = matrix_at(sums.L, p);
  Mat3<T> D;
  for (int c = 0; c < 3; ++c) D.column(c) = D_s.c0 * L(c, 0) + D_s.c1 * L(c, 1) + D_s.c2 * L(c, 2);
  const T volume = D_s(0, 0) + D_s(1, 1) + D_s(2, 2) + at_walls - dot(u, vector_at(sums.walls, p));
  const T rest = (volume - (D(0, 0) + D(1, 1) + D(2, 2))) * T(1.0 / 3);
  for (int k = 0; k < 3; ++k) D(k, k) += rest;
  return D;
}

// Prepare what `stress_divergence` gathers, V s L, of symmetric stresses in `sums.s`.
template <class T>
void fill_stress_rows(std::size_t count, SphSums<T>& sums) {
  each_row(count, [&](std::size_t p) {
    const T V = sums.V.column(0)[p];
    const Mat3<T> Q = scaled(full(symmetric_at(sums.s, p)) * matrix_at(sums.L, p), V);
    for (int c = 0; c < 3; ++c) sums.row[c][p] = {Q.column(c).x, Q.column(c).y, Q.column(c).z, T(0)};
  });
}

// div_i = sum_j V_j (s_i L_i + s_j L_j) grad W_ij + tr s_i / 3 sum_b V_b L_i grad W_ib [Pa/m].
template <class T>
Vec3<T> stress_divergence(const SphPairs<T>& snow, const SphSums<T>& sums, std::size_t p) {
  using R = Lanes<T>;
  T sum[3];
  snow.sum(p, sum, [&](std::uint32_t e, int count, R(&out)[3]) {
    const Vec3<R> g = snow.template slope<R>(e, count);
    for (int c = 0; c < 3; ++c) {
      const auto q = gather_quartets<R>(sums.row[c].data(), snow.row.data() + e);
      out[0] += q.a * g[c], out[1] += q.b * g[c], out[2] += q.c * g[c];
    }
  });
  const Sym3<T> s = symmetric_at(sums.s, p);
  const Mat3<T> L = matrix_at(sums.L, p);
  return Vec3<T>{sum[0], sum[1], sum[2]} + full(s) * (L * vector_at(sums.around, p)) +
         (L * vector_at(sums.walls, p)) * ((s.xx + s.yy + s.zz) * T(1.0 / 3));
}

}  // namespace neve
