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

// Snow is never softer than this share of what it was at birth: of snow that flies apart, numbers stay finite.
inline constexpr double softest = 1e-8;

namespace detail {

// The constants of the snow of particle p.
template <class T>
auto constants_at(const Model<T>& world, const SphState<T>& s, std::size_t p) {
  return Stomakhin2013::parameters<T>(world.snows[s.material[p]], s.stiffness.column(0)[p],
                                      s.strength.column(0)[p]);
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
    if (birth == T(0)) birth = rho0;
    const T J_P = birth / rho0;
    const T e = std::max(Stomakhin2013::hardening(J_P, q), T(softest));
    sums.rho0.column(0)[p] = rho0, sums.rho.column(0)[p] = rho, sums.V.column(0)[p] = m / rho;
    sums.lam.column(0)[p] = q.lam0 * e, sums.G.column(0)[p] = q.mu0 * e;
    s.J_P.column(0)[p] = J_P;
  });
}

// Of each particle the sums of gradients, and L = (sum_k V_k grad W_ik (x_k - x_i)^T)^-1 over snow and boundary, for which
// sum_k V_k (u_k - u_i) (L grad W_ik)^T is the gradient of a linear u. Where the moment is (nearly) singular, its inverse is
// 1 / s for singular values s above least_moment, s / least_moment^2 below.
template <class T>
void correct_gradients(SphState<T>& s, const Model<T>& world, const SphBoundary<T>& walls,
                       const SphPairs<T>& snow, const SphPairs<T>& boundary, SphSums<T>& sums) {
  using R = Lanes<T>;
  each_row(s.count, [&](std::size_t p) {
    T of_snow[13], of_walls[15];
    const auto moments = [&](const auto& others, const R& V, const Vec3<R>& g, const std::int32_t* rows,
                             auto& out) {
      for (int k = 0; k < 3; ++k) {
        const R d = gather<R>(others.x.column(k), rows) - s.x.column(k)[p];
        out[9 + k] += V * g[k];
        for (int i = 0; i < 3; ++i) out[3 * k + i] += V * g[i] * d;  // row i, column k
      }
    };
    snow.sum(p, of_snow, [&](std::uint32_t e, int count, R(&out)[13]) {
      const std::int32_t* rows = snow.row.data() + e;
      const Vec3<R> g = snow.template slope<R>(e, count);
      const R V = gather<R>(sums.V.column(0), rows);
      moments(s, V, g, rows, out);
      out[12] += V * dot(g, g);
    });
    boundary.sum(p, of_walls, [&](std::uint32_t e, int count, R(&out)[15]) {
      const std::int32_t* rows = boundary.row.data() + e;
      const Vec3<R> g = boundary.template slope<R>(e, count);
      const R V = gather<R>(walls.V.column(0), rows);
      moments(walls, V, g, rows, out);
      R leaves = splat<R>(0);
      for (int l = 0; l < count; ++l)
        leaves[l] =
            T(world.solids[std::size_t(walls.solid[std::size_t(rows[l])])].mode == ContactMode::separate);
      for (int k = 0; k < 3; ++k) out[12 + k] += V * g[k] * leaves;
    });
    for (int k = 0; k < 9; ++k) sums.L.column(k)[p] = of_snow[k] + of_walls[k];
    for (int k = 0; k < 3; ++k) {
      sums.around.column(k)[p] = of_snow[9 + k];
      sums.walls.column(k)[p] = of_walls[9 + k];
      sums.loose.column(k)[p] = of_walls[12 + k];
    }
    sums.squares.column(0)[p] = sums.V.column(0)[p] * of_snow[12];
  });
  each_chunk((s.count + width<R> - 1) / width<R>, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t p = i * width<R>;
      const int count = int(std::min<std::size_t>(width<R>, s.count - p));
      const auto A = svd3(select(first_lanes<R>(count), load_matrix<R>(sums.L, p, count), identity<R>()));
      Mat3<R> scaled_V;
      for (int k = 0; k < 3; ++k) {
        const R sigma = A.sigma[k];
        const R inverse = sigma / max(sigma * sigma, splat<R>(T(least_moment * least_moment)));
        scaled_V.column(k) = A.V.column(k) * inverse;
      }
      const Mat3<R>& U = A.U;
      Mat3<R> L;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
          L(r, c) = scaled_V(r, 0) * U(c, 0) + scaled_V(r, 1) * U(c, 1) + scaled_V(r, 2) * U(c, 2);
      }
      store_matrix(sums.L, p, L, count);
    }
  });
}

}  // namespace neve
