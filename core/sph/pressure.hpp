// The implicit solve for pressure (Gissler et al. 2020, section 3.1; equations 5 to 8).
#pragma once

#include "sph/gradient.hpp"

namespace neve {

// How much pressure of snow is mirrored at boundaries (SPlisHSPlasH) [1].
inline constexpr double mirrored = 1.5;
// Relaxation of the Jacobi iteration [1].
inline constexpr double relaxation = 0.5;

// When an iteration ends: at an error no larger than `tolerance`, of any one particle no larger than `largest`, after `fewest`,
// or without having converged after `most`.
struct SolveLimits {
  double tolerance = 1e-5, largest = 1e-3;
  int fewest = 2, most = 200;
};
struct SolveReport {
  int iterations = 0;
  double residual = 0, largest = 0;  // relative; that of the particle with most, if there is such a thing
  bool converged = true;
};

namespace detail {

// grad p_i of the present pressures [Pa/m]. Snow pulls on no solid that it may leave.
template <class T>
Vec3<T> pressure_gradient(const SphPairs<T>& snow, const SphSums<T>& sums, const T* Vp, std::size_t p,
                          T mirror = T(mirrored)) {
  using R = Lanes<T>;
  T sum[3];
  snow.sum(p, sum, [&](std::uint32_t e, int count, R(&out)[3]) {
    const R pressure = gather<R>(Vp, snow.row.data() + e);
    const Vec3<R> g = snow.template slope<R>(e, count);
    for (int k = 0; k < 3; ++k) out[k] += pressure * g[k];
  });
  const T here = sums.p.column(0)[p];
  const Vec3<T> walls =
      here < T(0) ? vector_at(sums.walls, p) - vector_at(sums.loose, p) : vector_at(sums.walls, p);
  return Vec3<T>{sum[0], sum[1], sum[2]} + vector_at(sums.around, p) * here + walls * (mirror * here);
}

// div u of a vector field whose V u is in `quads`, at rest at boundaries [1/s for a velocity].
template <class T>
T divergence(const SphPairs<T>& snow, const SphSums<T>& sums, const Vec3<T>& here, std::size_t p) {
  Four<T> columns[3];
  sum_outer(snow, sums.quads.data(), p, columns);
  return columns[0][0] + columns[1][1] + columns[2][2] -
         dot(here, vector_at(sums.around, p) + vector_at(sums.walls, p));
}

// Fill `quads` with V u(p, count), packs of vectors.
template <class T, class F>
void fill_quads(std::size_t n, SphSums<T>& sums, F&& u) {
  using R = Lanes<T>;
  each_pack<T>(n, [&](std::size_t p, int count) {
    store_rows(u(p, count) * load<R>(sums.V.column(0) + p, count), sums.quads.data(), p, count);
  });
}

// Relaxed Jacobi steps on the pressures in `p`. `find_gradients()` prepares one; `relax(p)` sets `p_next` of a particle and
// returns what is left of its present pressure, relative.
template <class T, class Gradients, class Relax>
SolveReport relax_pressures(std::size_t n, const SolveLimits& limits, SphSums<T>& sums,
                            Gradients&& find_gradients, Relax&& relax) {
  std::vector<T> error(n);
  SolveReport report;
  for (;;) {
    find_gradients();
    each_row(n, [&](std::size_t p) { error[p] = relax(p); });
    const double sum = sum_rows(n, [&](std::size_t p) { return double(error[p]); });
    report.residual = n ? sum / double(n) : 0;
    report.largest = largest_of_rows(n, [&](std::size_t p) { return double(error[p]); });
    report.converged = report.residual <= limits.tolerance && report.largest <= limits.largest;
    if ((report.converged && report.iterations >= limits.fewest) || report.iterations >= limits.most ||
        !std::isfinite(report.residual))
      return report;
    std::swap(sums.p, sums.p_next);
    ++report.iterations;
  }
}

}  // namespace detail

// Solve A p = -(rho_0 / lam) p + dt^2 div grad p = rho_0 - rho* by relaxed Jacobi steps from the pressures of the last step,
// for pressures of either sign, with rho* = rho - dt rho div v* and v* = v + dt `given`; `pressed` becomes -grad p / rho.
//
// The residual is the mean of |rho_0 - rho* - A p| / rho_0, and the largest is that of one particle: where a few are pressed
// in much snow at rest, the mean tells nothing of them.
template <class T>
SolveReport solve_pressure(const SphState<T>& s, const SphPairs<T>& snow, double dt,
                           const SolveLimits& limits, SphSums<T>& sums) {
  using R = Lanes<T>;
  const std::size_t n = s.count;
  const T step = T(dt), step2 = step * step;
  std::vector<T> missing(n), diagonal(n), Vp(n + 64);
  detail::fill_quads(n, sums, [&](std::size_t p, int count) {
    return load_vector<R>(s.v, p, count) + load_vector<R>(sums.given, p, count) * step;
  });
  each_row(n, [&](std::size_t p) {
    const T rho = sums.rho.column(0)[p], rho0 = sums.rho0.column(0)[p];
    const Vec3<T> v_star = vector_at(s.v, p) + vector_at(sums.given, p) * step;
    const T div = detail::divergence(snow, sums, v_star, p) + sums.inflow.column(0)[p];
    missing[p] = rho0 - (rho - step * rho * div);
    const Vec3<T> around = vector_at(sums.around, p), walls = vector_at(sums.walls, p);
    diagonal[p] = -rho0 / sums.lam.column(0)[p] -
                  step2 * (sums.squares.column(0)[p] + dot(around + walls * T(mirrored), around + walls));
    sums.p.column(0)[p] = s.p_last.column(0)[p];
  });
  const auto find_gradients = [&] {
    each_row(n, [&](std::size_t p) { Vp[p] = sums.V.column(0)[p] * sums.p.column(0)[p]; });
    each_row(n, [&](std::size_t p) {
      set_vector(sums.pressed, p, detail::pressure_gradient(snow, sums, Vp.data(), p));
    });
    detail::fill_quads(n, sums,
                       [&](std::size_t p, int count) { return load_vector<R>(sums.pressed, p, count); });
  };
  const SolveReport report = detail::relax_pressures(n, limits, sums, find_gradients, [&](std::size_t p) {
    const T laplacian = detail::divergence(snow, sums, vector_at(sums.pressed, p), p);
    const T here = sums.p.column(0)[p], rho0 = sums.rho0.column(0)[p];
    const T left = missing[p] + rho0 / sums.lam.column(0)[p] * here - step2 * laplacian;
    sums.p_next.column(0)[p] = here + T(relaxation) / diagonal[p] * left;
    return std::abs(left) / rho0;
  });
  each_row(n, [&](std::size_t p) {
    set_vector(sums.pressed, p, vector_at(sums.pressed, p) * (T(-1) / sums.rho.column(0)[p]));
  });
  return report;
}

}  // namespace neve
