// Water among snow: a fluid phase whose deformation nothing keeps, in the kernel's sums.
//
// Neighbours of the own phase stand in the sums of the snow as ever; what is across the surface between snow and water is
// added here. Of water, with V* = V0 of water and V0 min(1, |det F_E| J_P) of snow,
//
//   fill = sum_j V*_j W_ij + filled by boundaries,   V = V0 / max(fill, 1),   rho = m / V,   rho_0 and lam = those of the fluid.
//
// Water is at rest as it is born: `rho_birth` is the fluid's density times the fill that is without pressure, that at birth,
// which beside walls and slopes is not quite 1. What is above 1 of it is lost as the kernel empties.
//
// Beside water a particle of snow counts with V*, not with m / rho, which is too large at its surface: `share` is V* / V.
#pragma once

#include "sph/density.hpp"
#include "sph/gradient.hpp"
#include "sph/pressure.hpp"

namespace neve {

// How full a kernel of water may be at birth without being under pressure [1]: the least, beside boundaries only; the most, of
// snow and water, so that of water that was put into water something is left to be pushed apart.
inline constexpr double least_at_birth = 0.95, most_at_birth = 1.2;

// How much of the pressure of particle p is mirrored at boundaries [1]. Of water, what boundaries do is the gradient of what
// they fill, as between particles: so no work is done but on what is filled, and water comes to rest. With more, it boils.
template <class T>
T mirrored_at(const SphState<T>& s, std::size_t p) {
  return s.is_water(p) ? T(1) : T(mirrored);
}

namespace detail {

// How much of the kernel of a particle of water is filled, by particles of the volumes `space` and by boundaries.
template <class T>
T filled(const CubicKernel<T>& kernel, const SphState<T>& s, const SphBoundary<T>& walls,
         const SphPairs<T>& snow, const SphPairs<T>& boundary, const std::vector<T>& space, std::size_t p) {
  using R = Lanes<T>;
  const auto weighted = [&](const auto& others, const T* V, const SphPairs<T>& pairs) {
    return [&others, &pairs, &kernel, &s, V, p](std::uint32_t e, int count, R(&out)[1]) {
      const std::int32_t* rows = pairs.row.data() + e;
      Vec3<R> x;
      for (int k = 0; k < 3; ++k) x[k] = s.x.column(k)[p] - gather<R>(others.x.column(k), rows);
      const R w = gather<R>(V, rows) * kernel.value(dot(x, x));
      out[0] += select(first_lanes<R>(count), w, splat<R>(0));
    };
  };
  T own[1], other[1];
  snow.sum(p, own, weighted(s, space.data(), snow));
  snow.sum_across(p, other, weighted(s, space.data(), snow));
  return space[p] * kernel.at_zero() + own[0] + other[0] + boundary.filled[p];
}

}  // namespace detail

// Set what a step needs of water; after `find_densities`.
template <class T>
void fill_water(const CubicKernel<T>& kernel, SphState<T>& s, const SphBoundary<T>& walls,
                const SphPairs<T>& snow, const SphPairs<T>& boundary, SphSums<T>& sums) {
  if (!s.has_water()) return;
  std::vector<T> space(s.count);
  each_row(s.count, [&](std::size_t p) {
    const T V0 = s.V0.column(0)[p], J = std::abs(determinant(matrix_at(s.F_E, p)));
    space[p] = s.is_water(p) ? V0 : V0 * std::min(T(1), J * s.J_P.column(0)[p]);
    sums.share.column(0)[p] = s.is_water(p) ? T(1) : space[p] / sums.V.column(0)[p];
    sums.fill.column(0)[p] = T(1), sums.touch.column(0)[p] = T(0);
  });
  each_row(s.count, [&](std::size_t p) {
    if (!s.is_water(p)) return;
    const T fill = detail::filled(kernel, s, walls, snow, boundary, space, p);
    const T V = s.V0.column(0)[p] / std::max(fill, T(1));
    T& rest = s.rho_birth.column(0)[p];
    const T rho0 = T(s.water.rho0);
    if (rest == T(0)) {
      const T beside = boundary.filled[p];
      rest = rho0 * std::clamp(fill, beside > T(0) ? T(least_at_birth) : T(1), T(most_at_birth) + beside);
    } else if (rest > rho0) {
      rest = std::clamp(fill * rho0, rho0, rest);
    }
    sums.fill.column(0)[p] = fill, sums.V.column(0)[p] = V, sums.rho.column(0)[p] = s.m.column(0)[p] / V;
    sums.rho0.column(0)[p] = T(s.water.rho0), sums.lam.column(0)[p] = T(s.water.bulk_modulus);
    sums.G.column(0)[p] = T(0), s.J_P.column(0)[p] = T(1);
  });
}

// Set `beside`; after `fill_water`.
template <class T>
void look_across(const SphState<T>& s, const SphPairs<T>& snow, SphSums<T>& sums) {
  using R = Lanes<T>;
  if (!s.has_water()) return;
  each_row(s.count, [&](std::size_t p) {
    T sum[3];
    snow.sum_across(p, sum, [&](std::uint32_t e, int count, R(&out)[3]) {
      const std::int32_t* rows = snow.row.data() + e;
      const R V = gather<R>(sums.V.column(0), rows) * gather<R>(sums.share.column(0), rows);
      const Vec3<R> g = snow.template slope<R>(e, count);
      for (int k = 0; k < 3; ++k) out[k] += V * g[k];
    });
    set_vector(sums.beside, p, Vec3<T>{sum[0], sum[1], sum[2]} * sums.share.column(0)[p]);
  });
}

// sum_j V_j (u_j - u_i) . grad W_ij over the other phase, of vectors whose V u is in `quads`.
template <class T>
T inflow_across(const SphPairs<T>& snow, const SphSums<T>& sums, const Vec3<T>& u, std::size_t p) {
  using R = Lanes<T>;
  T sum[1];
  snow.sum_across(p, sum, [&](std::uint32_t e, int count, R(&out)[1]) {
    const std::int32_t* rows = snow.row.data() + e;
    const auto q = gather_quartets<R>(sums.quads.data(), rows);
    const Vec3<R> g = snow.template slope<R>(e, count);
    out[0] += (q.a * g.x + q.b * g.y + q.c * g.z) * gather<R>(sums.share.column(0), rows);
  });
  return sum[0] * sums.share.column(0)[p] - dot(u, vector_at(sums.beside, p));
}

// The same of all particles, in `across`, of vectors u(p, count); nothing where there is no water.
template <class T, class U>
void find_across(const SphState<T>& s, const SphPairs<T>& snow, SphSums<T>& sums, U&& u) {
  using R = Lanes<T>;
  if (!s.has_water()) return;
  each_pack<T>(s.count, [&](std::size_t p, int count) {
    const Vec3<R> here = u(p, count);
    for (int l = 0; l < count; ++l)
      sums.across.column(0)[p + std::size_t(l)] =
          inflow_across(snow, sums, Vec3<T>{here.x[l], here.y[l], here.z[l]}, p + std::size_t(l));
  });
}

// What the trace of the stress of shear, a pressure, adds to div s across the surface of snow in water, on both sides
// [Pa/m], where it presses.
template <class T>
Vec3<T> trace_across(const SphPairs<T>& snow, const SphSums<T>& sums, const T* press, std::size_t p) {
  using R = Lanes<T>;
  T sum[3];
  snow.sum_across(p, sum, [&](std::uint32_t e, int count, R(&out)[3]) {
    const std::int32_t* rows = snow.row.data() + e;
    const R there = gather<R>(press, rows) * gather<R>(sums.share.column(0), rows);
    const Vec3<R> g = snow.template slope<R>(e, count);
    for (int k = 0; k < 3; ++k) out[k] += there * g[k];
  });
  const T own = press[p] / sums.V.column(0)[p];
  return Vec3<T>{sum[0], sum[1], sum[2]} * sums.share.column(0)[p] + vector_at(sums.beside, p) * own;
}

}  // namespace neve
