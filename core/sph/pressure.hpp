// The implicit solve for pressure (Gissler et al. 2020, section 3.1; equations 5 to 8).
#pragma once

#include "sph/pairs.hpp"

namespace neve {

// How much pressure of snow is mirrored at boundaries (SPlisHSPlasH) [1].
inline constexpr double mirrored = 1.5;
// Relaxation of the Jacobi iteration [1].
inline constexpr double relaxation = 0.5;

// When an iteration ends: at an error no larger than `tolerance`, after `fewest`, or without having converged after `most`.
struct SolveLimits {
  double tolerance = 1e-5;
  int fewest = 2, most = 200;
};
struct SolveReport {
  int iterations = 0;
  double residual = 0;  // relative
  bool converged = true;
};

namespace detail {

// grad p_i of the present pressures [Pa/m]. Snow pulls on no solid that it may leave.
template <class T>
Vec3<T> pressure_gradient(const SphPairs<T>& snow, const SphSums<T>& sums, const T* Vp, std::size_t p) {
  using R = Lanes<T>;
  T sum[3];
  snow.sum(p, sum, [&](std::uint32_t e, int count, R(&out)[3]) {
    const R pressure = gather<R>(Vp, snow.row.data() + e);
    const Vec3<R> g = snow.template slope<R>(e, count);
    for (int k = 0; k < 3; ++k) out[k] += pressure * g[k];
  });
  const T here = sums.p.column(0)[p], mirror = T(mirrored);
  const Vec3<T> walls =
      here < T(0) ? vector_at(sums.walls, p) - vector_at(sums.loose, p) : vector_at(sums.walls, p);
  return Vec3<T>{sum[0], sum[1], sum[2]} + vector_at(sums.around, p) * here + walls * (mirror * here);
}

// div u of a vector field that is in `quads`, times V, at rest at boundaries [1/s for a velocity].
template <class T>
T divergence(const SphPairs<T>& snow, const SphSums<T>& sums, const Vec3<T>& here, std::size_t p) {
  using R = Lanes<T>;
  T sum[1];
  snow.sum(p, sum, [&](std::uint32_t e, int count, R(&out)[1]) {
    const auto u = gather_quartets<R>(sums.quads.data(), snow.row.data() + e);
    const Vec3<R> g = snow.template slope<R>(e, count);
    out[0] += u.a * g.x + u.b * g.y + u.c * g.z;
  });
  return sum[0] - dot(here, vector_at(sums.around, p) + vector_at(sums.walls, p));
}

// Fill `quads` with V u of each particle.
template <class T, class F>
void fill_quads(std::size_t count, SphSums<T>& sums, F&& u) {
  each_row(count, [&](std::size_t p) {
    const T V = sums.V.column(0)[p];
    const Vec3<T> a = u(p);
    sums.quads[p] = {V * a.x, V * a.y, V * a.z, V};
  });
}

}  // namespace detail

// Solve A p = -(rho_0 / lam) p + dt^2 div grad p = rho_0 - rho* by relaxed Jacobi steps from p = 0, for pressures of either
// sign, with rho* = rho - dt rho div v* and v* = v + dt `given`; `pressed` becomes -grad p / rho.
//
// The residual is the mean of |rho_0 - rho* - A p| / rho_0.
template <class T>
SolveReport solve_pressure(const SphState<T>& s, const SphPairs<T>& snow, double dt,
                           const SolveLimits& limits, SphSums<T>& sums) {
  const std::size_t n = s.count;
  const T step = T(dt), step2 = step * step;
  const auto v_star = [&](std::size_t p) { return vector_at(s.v, p) + vector_at(sums.given, p) * step; };
  std::vector<T> missing(n), diagonal(n), Vp(n + 64);
  detail::fill_quads(n, sums, v_star);
  each_row(n, [&](std::size_t p) {
    const T rho = sums.rho.column(0)[p], rho0 = sums.rho0.column(0)[p];
    const T div = detail::divergence(snow, sums, v_star(p), p) + sums.inflow.column(0)[p];
    missing[p] = rho0 - (rho - step * rho * div);
    const Vec3<T> around = vector_at(sums.around, p), walls = vector_at(sums.walls, p);
    diagonal[p] = -rho0 / sums.lam.column(0)[p] -
                  step2 * (sums.squares.column(0)[p] + dot(around + walls * T(mirrored), around + walls));
    sums.p.column(0)[p] = T(0);
  });
  SolveReport report;
  for (;;) {
    each_row(n, [&](std::size_t p) { Vp[p] = sums.V.column(0)[p] * sums.p.column(0)[p]; });
    each_row(n, [&](std::size_t p) {
      set_vector(sums.pressed, p, detail::pressure_gradient(snow, sums, Vp.data(), p));
    });
    detail::fill_quads(n, sums, [&](std::size_t p) { return vector_at(sums.pressed, p); });
    const double error = sum_rows(n, [&](std::size_t p) {
      const T laplacian = detail::divergence(snow, sums, vector_at(sums.pressed, p), p);
      const T here = sums.p.column(0)[p], rho0 = sums.rho0.column(0)[p];
      const T left = missing[p] + rho0 / sums.lam.column(0)[p] * here - step2 * laplacian;
      sums.p_next.column(0)[p] = here + T(relaxation) / diagonal[p] * left;
      return std::abs(double(left)) / double(rho0);
    });
    report.residual = n ? error / double(n) : 0;
    report.converged = report.residual <= limits.tolerance;
    if ((report.converged && report.iterations >= limits.fewest) || report.iterations >= limits.most ||
        !std::isfinite(report.residual))
      break;
    std::swap(sums.p, sums.p_next);
    ++report.iterations;
  }
  each_row(n, [&](std::size_t p) {
    set_vector(sums.pressed, p, vector_at(sums.pressed, p) * (T(-1) / sums.rho.column(0)[p]));
  });
  return report;
}

}  // namespace neve
