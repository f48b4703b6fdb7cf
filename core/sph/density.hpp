// Densities, hardening, and the correction of the kernel's gradient (Gissler et al. 2020, sections 3.3.2 and 3.2).
#pragma once

#include "constitutive/stomakhin2013.hpp"
#include "cpu/fields.hpp"
#include "math/svd3.hpp"
#include "sph/pairs.hpp"

namespace neve {

// Singular values of the moment of the kernel's gradient below this are not inverted as they are: lone particles, lines
// and sheets have no gradient in every direction.
inline constexpr double least_moment = 0.1;

// The least share of the kernel that boundaries leave to snow, in the density of snow deep among them [1].
inline constexpr double least_room = 0.25;

// lam is at least this of G: the pressure solve divides by it, and nu may be 0.
inline constexpr double least_lam = 1e-6;

// Snow is never softer than this share of what it was at birth: of snow that flies apart, numbers stay finite.
inline constexpr double softest = 1e-8;

namespace detail {

// The constants of the snow of particle p.
template <class T>
auto constants_at(const Model<T>& world, const SphState<T>& s, std::size_t p) {
  return Stomakhin2013::parameters<T>(world.snows[s.material[p]], s.stiffness.column(0)[p],
                                      s.strength.column(0)[p]);
}

// The sums of gradients of particle p, and its moment, which is left in L.
template <class T>
void sum_gradients(const SphState<T>& s, const Model<T>& world, const SphBoundary<T>& walls,
                   const SphPairs<T>& snow, const SphPairs<T>& boundary, SphSums<T>& sums, std::size_t p) {
  using R = Lanes<T>;
  T of_snow[13], of_walls[6];
  snow.sum(p, of_snow, [&](std::uint32_t e, int count, R(&out)[13]) {
    const std::int32_t* rows = snow.row.data() + e;
    const Vec3<R> g = snow.template slope<R>(e, count);
    const R V = gather<R>(sums.V.column(0), rows);
    for (int k = 0; k < 3; ++k) {
      const R d = gather<R>(s.x.column(k), rows) - s.x.column(k)[p];
      out[9 + k] += V * g[k];
      for (int i = 0; i < 3; ++i) out[3 * k + i] += V * g[i] * d;  // row i, column k
    }
    out[12] += V * dot(g, g);
  });
  boundary.sum(p, of_walls, [&](std::uint32_t e, int count, R(&out)[6]) {
    const std::int32_t* rows = boundary.row.data() + e;
    const Vec3<R> g = boundary.template slope<R>(e, count);
    const R V = gather<R>(walls.V.column(0), rows);
    R leaves = splat<R>(0);
    for (int l = 0; l < count; ++l)
      leaves[l] =
          T(world.solids[std::size_t(walls.solid[std::size_t(rows[l])])].mode == ContactMode::separate);
    for (int k = 0; k < 3; ++k) out[k] += V * g[k], out[3 + k] += V * g[k] * leaves;
  });
  for (int k = 0; k < 9; ++k) sums.L.column(k)[p] = of_snow[k];
  for (int k = 0; k < 3; ++k) {
    sums.around.column(k)[p] = of_snow[9 + k];
    sums.walls.column(k)[p] = of_walls[k], sums.loose.column(k)[p] = of_walls[3 + k];
  }
  sums.squares.column(0)[p] = sums.V.column(0)[p] * of_snow[12];
}

// L and P of the pack of particles from p on, whose moments are in L.
template <class T>
void invert_moments(std::size_t n, SphSums<T>& sums, std::size_t p) {
  using R = Lanes<T>;
  const int count = int(std::min<std::size_t>(width<R>, n - p));
  const auto A = svd3(select(first_lanes<R>(count), load_matrix<R>(sums.L, p, count), identity<R>()));
  Mat3<R> L{}, P{};
  for (int k = 0; k < 3; ++k) {
    const R sigma = A.sigma[k], least = splat<R>(T(least_moment));
    const R inverse = R(T(1) / max(sigma, least)) * min(R(sigma / least), splat<R>(1));
    const R kept = select(sigma < least, R(sigma * inverse), splat<R>(1));
    const Vec3<R>& u = A.U.column(k);
    for (int c = 0; c < 3; ++c) {
      L.column(c) = L.column(c) + u * R(u[c] * inverse);
      P.column(c) = P.column(c) + u * R(u[c] * kept);
    }
  }
  store_matrix(sums.L, p, L, count), store_matrix(sums.P, p, P, count);
}

}  // namespace detail

// Of each particle:
//
//   rho = sum_j m_j W_ij + rho_0 sum_b V_b W_ib,   rho_0 = rho |det F_E|   (both at once)
//   J_P = rho_birth / rho_0,     lam, G = (lam0, G0) exp(xi (1 - J_P))
//
// The last is exp(xi (rho_0 - rho_birth) / rho_0), hardening as in Stomakhin et al. 2013; rho_birth is each particle's own,
// since a sum over neighbours is lower at a surface: with that of the snow, surfaces would be soft from the start. Equation 20 of the paper leaves
// boundaries out of rho_0 but not out of rho (as public ports have it): unstrained snow beside a wall would be under
// pressure there (docs/sph.md).
template <class T>
void find_densities(const CubicKernel<T>& kernel, const Model<T>& world, SphState<T>& s,
                    const SphBoundary<T>& walls, const SphPairs<T>& snow, const SphPairs<T>& boundary,
                    SphSums<T>& sums) {
  using R = Lanes<T>;
  each_row(s.count, [&](std::size_t p) {
    const auto density = [&](const auto& others, const T* weights, const SphPairs<T>& pairs) {
      T sum[1];
      pairs.sum(p, sum, [&](std::uint32_t e, int count, R(&out)[1]) {
        const std::int32_t* rows = pairs.row.data() + e;
        Vec3<R> x;
        for (int k = 0; k < 3; ++k) x[k] = s.x.column(k)[p] - gather<R>(others.x.column(k), rows);
        const R w = gather<R>(weights, rows) * kernel.value(dot(x, x));
        out[0] += select(first_lanes<R>(count), w, splat<R>(0));
      });
      return sum[0];
    };
    const T m = s.m.column(0)[p];
    const T of_snow = m * kernel.at_zero() + density(s, s.m.column(0), snow);
    const T covered = density(walls, walls.V.column(0), boundary);
    const T J = std::abs(determinant(matrix_at(s.F_E, p)));
    const T rho = of_snow / std::max(T(1) - J * covered, T(least_room)), rho0 = J * rho;
    const auto q = detail::constants_at(world, s, p);
    T& birth = s.rho_birth.column(0)[p];
    if (birth == T(0) && !s.is_water(p)) birth = rho0;
    const T J_P = birth / rho0;
    const T e = std::max(Stomakhin2013::hardening(J_P, q), T(softest));
    sums.rho0.column(0)[p] = rho0, sums.rho.column(0)[p] = rho, sums.V.column(0)[p] = m / rho;
    sums.lam.column(0)[p] = std::max(q.lam0, T(least_lam) * q.mu0) * e, sums.G.column(0)[p] = q.mu0 * e;
    s.J_P.column(0)[p] = J_P;
  });
}

// Of each particle the sums of gradients, and L = A^-1 of the moment A = sum_j V_j grad W_ij (x_j - x_i)^T over the snow, for
// which sum_j V_j (u_j - u_i) (L grad W_ij)^T is the gradient of a linear u. Where A is (nearly) singular, its inverse is
// 1 / s for singular values s above least_moment, s / least_moment^2 below; P = L A.
//
// The paper's moment has the boundary in it, but the gradient that L corrects (equation 17) has not: snow beside a wall
// would be strained as it turns.
template <class T>
void correct_gradients(SphState<T>& s, const Model<T>& world, const SphBoundary<T>& walls,
                       const SphPairs<T>& snow, const SphPairs<T>& boundary, SphSums<T>& sums) {
  each_row(s.count, [&](std::size_t p) { detail::sum_gradients(s, world, walls, snow, boundary, sums, p); });
  each_chunk((s.count + width<Lanes<T>> - 1) / width<Lanes<T>>, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) detail::invert_moments(s.count, sums, i * width<Lanes<T>>);
  });
}

}  // namespace neve
