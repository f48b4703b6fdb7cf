// Sums over all snow; and rates that bound the step: of pressed snow, and of the bodies that it touches.
#pragma once

#include "sph/density.hpp"

namespace neve {

struct SphTotals {
  double mass = 0, momentum[3] = {0, 0, 0}, kinetic = 0, potential = 0, elastic = 0;
  void add(const SphTotals& o) {
    mass += o.mass, kinetic += o.kinetic, potential += o.potential, elastic += o.elastic;
    for (int k = 0; k < 3; ++k) momentum[k] += o.momentum[k];
  }
};

// Sums in double, in chunks merged in order. The elastic energy is (lam (J - 1 - ln J) + G |F - 1|^2) m / rho_0. The first
// part is exactly what the pressure lam (1 / J - 1) does, V p dJ / J; of the second, the stress 2 G (F - 1) does
// J / s_k times as much along a stretch s_k, the same to the order of the strains.
template <class T>
SphTotals totals(const Vec3<T>& gravity, const SphState<T>& s, const SphSums<T>& sums) {
  constexpr std::size_t chunk = 1024;
  std::vector<SphTotals> parts((s.count + chunk - 1) / chunk);
  each_index(parts.size(), [&](std::size_t part) {
    SphTotals& sum = parts[part];
    for (std::size_t p = part * chunk; p < std::min(s.count, (part + 1) * chunk); ++p) {
      const double m = s.m.column(0)[p];
      sum.mass += m;
      for (int k = 0; k < 3; ++k) {
        const double v = s.v.column(k)[p];
        sum.momentum[k] += m * v, sum.kinetic += 0.5 * m * v * v;
        sum.potential -= m * double(gravity[k]) * double(s.x.column(k)[p]);
      }
      double squares = 0;
      for (int k = 0; k < 9; ++k) {
        const double e = double(s.F_E.column(k)[p]) - (k % 4 == 0 ? 1.0 : 0.0);
        squares += e * e;
      }
      const double grown = std::abs(double(determinant(matrix_at(s.F_E, p)))) - 1;
      sum.elastic += m / double(sums.rho0.column(0)[p]) *
                     (double(sums.G.column(0)[p]) * squares +
                      double(sums.lam.column(0)[p]) * (grown - std::log1p(grown)));
    }
  });
  SphTotals total;
  for (const SphTotals& part : parts) total.add(part);
  return total;
}

// Of a cubic lattice with the distance d of particles, under the pressure sigma along an axis, let every other plane across
// that axis be displaced along it. No velocity gradient or density sees that to first order, as what a particle comes near to on
// one side it leaves on the other: so the implicit solves do not, either. The gradients of the kernel do, and
// push back with omega^2 = 8 sigma V sum d2W/dz2 / rho, over the nine particles of a neighbouring plane: omega = this times
// sqrt(sigma / rho) / d. Of modes that alternate along more axes omega is lower.
inline constexpr double plane_frequency = 2.919;

// The largest such omega of the snow as it stands [1/s], of the largest principal pressure p - min s of each particle, with
// p = lam (1 / J - 1) and s = 2 G (F_E - 1). What swings so is integrated explicitly, and grows in steps above 2 / omega.
// Water, whose viscosity acts along the line of each pair, is left out.
template <class T>
double stress_rate(const CubicKernel<T>& kernel, const SphState<T>& s, const SphSums<T>& sums) {
  using R = Lanes<T>;
  std::vector<T> square(s.count + 64);
  each_pack<T>(s.count, [&](std::size_t p, int count) {
    const Mat3<R> F = select(first_lanes<R>(count), load_matrix<R>(s.F_E, p, count), identity<R>());
    const auto A = svd3(F);  // symmetric and positive: its stretches
    const R J = A.sigma[0] * A.sigma[1] * A.sigma[2];
    const R least = min(A.strain[0], min(A.strain[1], A.strain[2]));
    const R pressure = load<R>(sums.lam.column(0) + p, count) * (T(1) / J - T(1)) -
                       load<R>(sums.G.column(0) + p, count) * least * T(2);
    store(square.data() + p, R(pressure / load<R>(sums.rho.column(0) + p, count)), count);
  });
  const double most =
      largest_of_rows(s.count, [&](std::size_t p) { return s.is_water(p) ? 0.0 : double(square[p]); });
  return plane_frequency * std::sqrt(most) / (double(kernel.h) / 2);
}

// The largest rate [1/s] at which the snow that touches a body can change its velocity: its acoustic impedance
// sum_i rho_i c_i V_i |sum_b V_b grad W_ib| times the body's mobility at that place. The body's velocity is not an unknown
// of the solves, so that a step may not be longer than the inverse. Sums in chunks, added in order.
template <class T>
double body_rate(const Model<T>& world, const SphState<T>& s, const SphBoundary<T>& walls,
                 const SphPairs<T>& boundary, const SphSums<T>& sums) {
  constexpr std::size_t chunk = 1024;
  const std::size_t bodies = world.bodies.count();
  if (bodies == 0) return 0;
  const std::vector<LargestMobility> most = largest_mobility(world.bodies);
  std::vector<std::vector<std::pair<std::size_t, double>>> parts((s.count + chunk - 1) / chunk);
  each_index(parts.size(), [&](std::size_t part) {
    const auto add = [&](std::size_t body, double rate) {
      for (auto& [known, sum] : parts[part]) {
        if (known == body) return void(sum += rate);
      }
      parts[part].emplace_back(body, rate);
    };
    for (std::size_t p = part * chunk; p < std::min(s.count, (part + 1) * chunk); ++p) {
      if (s.is_water(p)) continue;  // the solve for pressure finds the bodies' velocities with its own
      const double modulus = double(sums.lam.column(0)[p]) + 2 * double(sums.G.column(0)[p]);
      const double impedance =
          std::sqrt(modulus * double(sums.rho.column(0)[p])) * double(sums.V.column(0)[p]);
      for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e) {
        const auto b = std::size_t(boundary.row[e]);
        const Solid<T>& solid = world.solids[std::size_t(walls.solid[b])];
        if (solid.body < 0) continue;
        const Vec3<T> g = boundary.slope_at(e), arm = vector_at(s.x, p) - solid.centre;
        const auto& [moves, turns] = most[std::size_t(solid.body)];
        add(std::size_t(solid.body), impedance * double(walls.V.column(0)[b]) * std::sqrt(double(dot(g, g))) *
                                         (moves + turns * double(dot(arm, arm))));
      }
    }
  });
  std::vector<double> rate(bodies);
  for (const auto& part : parts) {
    for (const auto& [body, sum] : part) rate[body] += sum;
  }
  return *std::max_element(rate.begin(), rate.end());
}

}  // namespace neve
