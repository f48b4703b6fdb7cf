// Heat of particles: what a scene says of it, and the state of one particle (docs/heat.md).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "constitutive/densities.hpp"

namespace neve {

namespace heat {

inline constexpr double latent = 3.34e5;   // heat of fusion [J/kg]
inline constexpr double c_ice = 2100;      // specific heat of ice and snow [J/(kg K)]
inline constexpr double c_water = 4182;    // and of water
inline constexpr double k_water = 0.6;     // conductivity of water [W/(m K)]
inline constexpr double melting = 273.15;  // [K]

// Change of the liquid share from which on size and strength of a particle follow it [1].
inline constexpr double phase_step = 2e-3;
// Of a difference of temperatures that may go in one round [1].
inline constexpr double most_change = 0.4;
// Rounds of one pass: a step of motion that asks for more would never end.
inline constexpr double most_rounds = 1e5;

// Temperature [deg C] of mass m [kg] with enthalpy e [J], which is zero for ice at the melting point: below zero solid, up
// to m latent a mush at the melting point, water above.
inline double temperature(double e, double m) {
  if (e < 0) return e / (m * c_ice);
  return std::max(e - m * latent, 0.0) / (m * c_water);
}

// Share of the mass that is liquid [1].
inline double liquid(double e, double m) { return std::clamp(e / (m * latent), 0.0, 1.0); }

// Conductivity of snow of density rho [W/(m K)]: Calonne et al. 2011.
inline double k_snow(double rho) { return std::max(2.5e-6 * rho * rho - 1.23e-4 * rho + 0.024, 0.01); }

// Volume over that at birth of what is all ice, and of what is all water, for snow of density `born` [kg/m3].
inline double ratio_of_ice(double born) { return std::min(born / ice_density, 1.0); }
inline double ratio_of_water(double born) { return std::min(born / water_density, ratio_of_ice(born)); }

// Volume ratio of the solid part where the share f of the mass is liquid and that of all is J.
inline double solid_ratio(double J, double f, double born) {
  return f < 1 ? (J - f * ratio_of_water(born)) / (1 - f) : ratio_of_ice(born);
}

// Volume ratio J after the liquid share went from f to `now`. What melts loses its pores; what freezes is ice.
inline double ratio_after(double J, double f, double now, double born) {
  const double J_water = ratio_of_water(born), J_ice = ratio_of_ice(born);
  if (now <= f) return J + (f - now) * (J_ice - J_water);
  return (1 - now) * solid_ratio(J, f, born) + now * J_water;
}

}  // namespace heat

// What a scene says of heat.
struct HeatModel {
  double air = 0;                          // temperature [deg C]
  double exchange = 0;                     // of a surface with air [W/(m2 K)]
  double sun = 0;                          // that snow absorbs where it faces the sun [W/m2]
  std::array<double, 3> towards{0, 0, 1};  // the sun
  double conductivity = 0;                 // of all phases; zero: as density and phase say [W/(m K)]
  double speed = 1;                        // seconds of heat in a second of motion [1]
  bool sinters = false;                    // contacts and bonds at rest grow stronger

  double conductivity_of(double rho, double liquid) const {
    if (conductivity > 0) return conductivity;
    return (1 - liquid) * heat::k_snow(std::min(rho, ice_density)) + liquid * heat::k_water;
  }
};

// What a pass found.
struct HeatReport {
  double taken = 0;  // from air and sun [J]
  int rounds = 0;    // in which it was made
  bool finite = true;
  bool endless = false;  // so many that it was not made

  // Of a pass in which differences of temperature would shrink by `change` at once [1].
  static HeatReport of(double change) {
    const double rounds = std::max(1.0, std::ceil(change / heat::most_change));
    HeatReport report;
    report.rounds = int(std::min(rounds, 2e9)), report.endless = rounds > heat::most_rounds;
    return report;
  }
};

// Let heat flow for dt [s] between `count` particles, in as many rounds as that asks for. rate(p): the sum of its conductances
// [W/K]; mass(p) [kg]; exchange(h): a round of h [s], which adds to `enthalpy`, and to `taken` what came from air and sun [J].
template <class Rate, class Mass, class Exchange>
HeatReport flow_in_rounds(double dt, std::size_t count, Rate&& rate, Mass&& mass, Exchange&& exchange,
                          const double* enthalpy, const double* taken) {
  double fastest = 0;
  for (std::size_t p = 0; p < count; ++p) fastest = std::max(fastest, rate(p) / (mass(p) * heat::c_ice));
  HeatReport report = HeatReport::of(dt * fastest);
  if (report.endless) return report;
  for (int round = 0; round < report.rounds; ++round) exchange(dt / report.rounds);
  for (std::size_t p = 0; p < count; ++p) {
    report.taken += taken[p];
    report.finite = report.finite && std::isfinite(enthalpy[p]);
  }
  return report;
}

}  // namespace neve
