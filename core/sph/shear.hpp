// The implicit solve for shear (Gissler et al. 2020, section 3.2).
#pragma once

#include "sph/bicgstab.hpp"
#include "sph/gradient.hpp"

namespace neve {

namespace detail {

// factor (A F + (A F)^T).
template <class T>
Sym3<T> twice_symmetric(const Mat3<T>& A, const Mat3<T>& F, T factor) {
  const Mat3<T> B = A * F;
  return {T(2) * factor * B(0, 0),      T(2) * factor * B(1, 1),      T(2) * factor * B(2, 2),
          factor * (B(0, 1) + B(1, 0)), factor * (B(0, 2) + B(2, 0)), factor * (B(1, 2) + B(2, 1))};
}

}  // namespace detail

// With F* = F + dt D[v + dt (given + pressed)] F and the stress s = G (F + F^T - 2), find the acceleration
//
//   a = div s(F* + dt^2 D[a] F) / rho,   that is   M a = b,
//   M a = a - dt^2 div G (D[a] F + (D[a] F)^T) / rho,   b = div s(F*) / rho.
//
// (F_next = F + dt D[v* + dt a] F, hence dt squared.) `sheared` becomes div s / rho with the stress at the end, which is
// left in `sums.s`: so what pairs give each other is opposite to rounding, however far the iteration went.
template <class T>
SolveReport solve_shear(const SphState<T>& s, const SphPairs<T>& snow, double dt, const SolveLimits& limits,
                        SphSums<T>& sums) {
  const std::size_t n = s.count;
  const T step = T(dt);
  const auto divergence = [&](Vectors<T>& out, auto&& more) {
    fill_stress_rows(n, sums);
    each_row(n, [&](std::size_t p) {
      const Vec3<T> a = stress_divergence(snow, sums, p) * (T(1) / sums.rho.column(0)[p]);
      set_vector(out, p, more(p, a));
    });
  };
  const auto only = [](std::size_t, const Vec3<T>& a) { return a; };
  const auto predicted = [&](std::size_t p) {
    return vector_at(s.v, p) + (vector_at(sums.given, p) + vector_at(sums.pressed, p)) * step;
  };
  // The stress of F + dt D[u] F: the part of F, or that of the change, or both.
  Vectors<T> b, a;
  b.resize(n), a.resize(n);
  detail::fill_quads(n, sums, predicted);
  each_row(n, [&](std::size_t p) {
    const Mat3<T> F = matrix_at(s.F_E, p);
    const T G = sums.G.column(0)[p];
    const Mat3<T> D = velocity_gradient(snow, sums, predicted(p), sums.inflow.column(0)[p], p);
    Sym3<T> stress = detail::twice_symmetric(D, F, G * step);
    stress.xx += T(2) * G * (F(0, 0) - T(1)), stress.yy += T(2) * G * (F(1, 1) - T(1));
    stress.zz += T(2) * G * (F(2, 2) - T(1));
    stress.xy += G * (F(0, 1) + F(1, 0)), stress.xz += G * (F(0, 2) + F(2, 0)),
        stress.yz += G * (F(1, 2) + F(2, 1));
    set_symmetric(sums.s, p, stress);
  });
  Field<T, 6> start;
  start.resize(n);
  each_row(n, [&](std::size_t p) { set_symmetric(start, p, symmetric_at(sums.s, p)); });
  divergence(b, only);
  const auto change = [&](const Vectors<T>& u) {  // dt^2 G (D[u] F + (D[u] F)^T)
    detail::fill_quads(n, sums, [&](std::size_t p) { return vector_at(u, p); });
    each_row(n, [&](std::size_t p) {
      const Mat3<T> D = velocity_gradient(snow, sums, vector_at(u, p), T(0), p);
      set_symmetric(sums.s, p,
                    detail::twice_symmetric(D, matrix_at(s.F_E, p), sums.G.column(0)[p] * step * step));
    });
  };
  const SolveReport report = bicgstab<T>(
      [&](const Vectors<T>& u, Vectors<T>& out) {
        change(u);
        divergence(out, [&](std::size_t p, const Vec3<T>& by) { return vector_at(u, p) - by; });
      },
      b, a, limits);
  change(a);
  each_row(n, [&](std::size_t p) {
    for (int k = 0; k < 6; ++k) sums.s.column(k)[p] += start.column(k)[p];
  });
  divergence(sums.sheared, only);
  return report;
}

}  // namespace neve
