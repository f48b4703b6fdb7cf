// Sums over all snow; and how strongly it holds the bodies that it touches.
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

// Sums in double, in chunks merged in order. The elastic energy is that of the stress lam (J - 1) + 2 G (F - 1) with the
// moduli of the last step: (G |F - 1|^2 + lam (J - 1)^2 / 2) m / rho_0.
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
      const double volume = std::abs(double(determinant(matrix_at(s.F_E, p)))) - 1;
      sum.elastic +=
          m / double(sums.rho0.column(0)[p]) *
          (double(sums.G.column(0)[p]) * squares + 0.5 * double(sums.lam.column(0)[p]) * volume * volume);
    }
  });
  SphTotals total;
  for (const SphTotals& part : parts) total.add(part);
  return total;
}

// The largest rate [1/s] at which the snow that touches a body can change its velocity: its acoustic impedance
// sum_i rho_i c_i V_i |sum_b V_b grad W_ib| times the body's mobility at that place. The body's velocity is not an unknown
// of the solves, so that a step may not be longer than the inverse.
template <class T>
double body_rate(const Model<T>& world, const SphState<T>& s, const SphBoundary<T>& walls,
                 const SphPairs<T>& boundary, const SphSums<T>& sums) {
  const std::size_t bodies = world.bodies.solids.size();
  std::vector<double> rate(bodies);
  if (bodies == 0) return 0;
  for (std::size_t p = 0; p < s.count; ++p) {
    const double modulus = double(sums.lam.column(0)[p]) + 2 * double(sums.G.column(0)[p]);
    const double impedance = std::sqrt(modulus * double(sums.rho.column(0)[p])) * double(sums.V.column(0)[p]);
    for (std::uint32_t e = boundary.begin[p]; e < boundary.begin[p + 1]; ++e) {
      const auto b = std::size_t(boundary.row[e]);
      const Solid<T>& solid = world.solids[std::size_t(walls.solid[b])];
      if (solid.body < 0) continue;
      double g2 = 0, arm2 = 0, moves = 0, turns = 0;
      const std::size_t n = 6 * bodies, first = 6 * std::size_t(solid.body);
      for (int k = 0; k < 3; ++k) {
        const double g = boundary.gradient[k][e], arm = double(s.x.column(k)[p]) - double(solid.centre[k]);
        g2 += g * g, arm2 += arm * arm;
        const std::size_t i = first + std::size_t(k);
        moves = std::max(moves, world.bodies.mobility[i * n + i]);
        turns = std::max(turns, world.bodies.mobility[(i + 3) * n + i + 3]);
      }
      rate[std::size_t(solid.body)] +=
          impedance * double(walls.V.column(0)[b]) * std::sqrt(g2) * (moves + turns * arm2);
    }
  }
  return *std::max_element(rate.begin(), rate.end());
}

}  // namespace neve
