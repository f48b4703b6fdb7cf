// Sintering (docs/heat.md): snow at rest bears more with time.
#pragma once

#include "heat/enthalpy.hpp"

namespace neve::sintering {

inline constexpr double power = 0.21;         // of time [1]
inline constexpr double unit = 1.0;           // time after which snow bears what it does at birth [s]
inline constexpr double warm = 268.15;        // temperature at which this holds [K]
inline constexpr double activation = 5.86e4;  // energy that slows it in the cold [J/mol]
inline constexpr double gas = 8.314;          // [J/(mol K)]
inline constexpr double at_rest = 0.1;        // strain rate up to which snow is at rest [1/s]
inline constexpr double breaking = 0.02;      // plastic strain that undoes it, of a continuum [1]
inline constexpr double of_loose = 0.1;     // strength at birth of what has no cohesion, of that of snow [1]
inline constexpr double of_density = 2.44;  // power of density with which strength grows [1]

// What snow bears after dt [s] at `celsius`, if it bears `hold` now and `young` when it is as old as the law's unit of time;
// never above `most`.
inline double grown(double hold, double young, double most, double celsius, double dt) {
  const double K = std::min(celsius, 0.0) + heat::melting;
  const double pace = std::exp(-activation / gas * (1 / K - 1 / warm));
  const double age = unit * std::pow(hold / young, 1 / power);
  return std::max(hold, std::min(young * std::pow((age + pace * dt) / unit, power), most));
}

// The strength of ice over that of snow of density rho [kg/m3].
inline double strength_of_ice(double rho) { return std::max(std::pow(ice_density / rho, of_density), 1.0); }

}  // namespace neve::sintering
