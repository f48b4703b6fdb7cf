// Sums over all particles.
#pragma once

#include "cpu/fields.hpp"
#include "cpu/material.hpp"
#include "heat/enthalpy.hpp"
#include "mpm/dispatch.hpp"
#include "mpm/energy.hpp"
#include "threads.hpp"

namespace neve {

struct Totals {
  double mass = 0;
  double momentum[3] = {0, 0, 0};
  double kinetic = 0;  // of v_p alone
  double affine = 0;   // kinetic energy of C and of further modes
  double elastic = 0;
  double potential = 0;  // -m g . x
  double heat = 0;       // enthalpy above that of ice at the melting point [J]
  double water = 0;      // mass that is liquid [kg]
};

namespace detail {

// Kinetic energy per mass of a particle's velocity modes but the first [J/kg].
template <class Spline, class Transfer, class T>
double affine_energy(const State<T>& state, std::size_t p, double dx) {
  if constexpr (!Transfer::keeps_C) return 0;
  double C[9], fraction[3];
  for (int k = 0; k < 9; ++k) C[k] = dx * state.C.column(k)[p];
  for (int a = 0; a < 3; ++a) {
    const double u = state.place(a, p) / dx - Spline::shift;
    fraction[a] = u - std::floor(u);
  }
  return modes_energy<Spline, Transfer>(C, fraction, [&](int k) { return double(state.modes.column(k)[p]); });
}

}  // namespace detail

// Sum in double, in chunks of fixed size merged in order: the same bits for any number of threads.
template <class T>
Totals totals(const Model<T>& model, const State<T>& state) {
  using R = Lanes<T>;
  constexpr std::size_t L = width<R>, chunk = 64 * L;
  std::vector<Totals> parts((state.count + chunk - 1) / chunk);
  const auto affine_energy = [&](std::size_t p) {
    return with_spline(model.spline, [&](auto spline) {
      return with_transfer(model, [&](auto transfer) {
        return detail::affine_energy<decltype(spline), decltype(transfer)>(state, p, model.dx);
      });
    });
  };
  each_index(parts.size(), [&](std::size_t c) {
    Totals& sum = parts[c];
    for (std::size_t p = c * chunk; p < std::min(state.count, (c + 1) * chunk); p += L) {
      const int count = static_cast<int>(std::min(L, state.count - p));
      const R psi = energy(model, state, p, count, load_matrix<R>(state.F_E, p, count),
                           load<R>(state.J_P.column(0) + p, count));
      for (int l = 0; l < count; ++l) {
        const std::size_t i = p + static_cast<std::size_t>(l);
        const double m = state.m.column(0)[i];
        double v2 = 0, gx = 0;
        for (int k = 0; k < 3; ++k) {
          const double v = state.v.column(k)[i];
          sum.momentum[k] += m * v;
          v2 += v * v;
          gx += static_cast<double>(model.gravity[k]) * state.place(k, i);
        }
        sum.mass += m;
        sum.kinetic += 0.5 * m * v2;
        sum.affine += m * affine_energy(i);
        sum.elastic += static_cast<double>(psi[l]) * state.V0.column(0)[i];
        sum.potential -= m * gx;
        if (state.has_heat()) {
          sum.heat += state.enthalpy.column(0)[i];
          sum.water += m * heat::liquid(state.enthalpy.column(0)[i], m);
        }
      }
    }
  });
  Totals total;
  for (const Totals& part : parts) {
    total.mass += part.mass;
    for (int k = 0; k < 3; ++k) total.momentum[k] += part.momentum[k];
    total.kinetic += part.kinetic;
    total.affine += part.affine;
    total.elastic += part.elastic;
    total.potential += part.potential;
    total.heat += part.heat;
    total.water += part.water;
  }
  return total;
}

}  // namespace neve
