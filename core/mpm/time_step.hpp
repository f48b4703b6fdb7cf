// What the passes over nodes and particles report: the rates that limit the next time step, and whether all is well.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace neve {

// Beyond these a step is not taken: it would carry a particle over more than a cell, or press it to less than a
// twentieth of its volume, on the way to turning it inside out.
inline constexpr double most_leap = 1.0;       // [cells]
inline constexpr double least_squeeze = 0.05;  // det(I + dt grad v) [1]

// What g2p found in the particles, or refresh() before the first step.
struct Report {
  static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

  double wave = 0;                 // largest elastic wave speed c = sqrt(modulus V0 / m), hardened [m/s]
  double speed = 0;                // largest particle speed |v| [m/s]
  double fastest = 0;              // largest c + |v| [m/s]
  double strain_rate = 0;          // largest |grad v| (Frobenius) [1/s]
  double press_rate = 0;           // largest -tr grad v [1/s]
  double leap = 0;                 // longest way of a particle in this step [cells]
  double squeeze = 1;              // smallest det(I + dt grad v) [1]
  bool finite = true;              // every particle has finite x, v, F_E, J_P and stress
  bool drifted = false;            // some particle left its home's tile: sort before the next p2g
  std::uint32_t culprit = nobody;  // lowest birth number among the particles that refuse the step

  bool refused() const { return !finite || leap > most_leap || squeeze < least_squeeze; }

  void merge(const Report& o) {
    wave = std::max(wave, o.wave);
    speed = std::max(speed, o.speed);
    fastest = std::max(fastest, o.fastest);
    strain_rate = std::max(strain_rate, o.strain_rate);
    press_rate = std::max(press_rate, o.press_rate);
    leap = std::max(leap, o.leap);
    squeeze = std::min(squeeze, o.squeeze);
    finite = finite && o.finite;
    drifted = drifted || o.drifted;
    culprit = std::min(culprit, o.culprit);
  }
};

// What grid_update found in the nodes, before any particle is moved. Nodes lighter than a thousandth of the lightest
// particle are left out: 27 or 64 of them together have a small part in a particle's velocity.
struct Ahead {
  double speed = 0;    // largest node speed [m/s]
  double spread = 0;   // largest difference of velocities within a home's tile [m/s]
  double change = 0;   // largest change of a node's velocity in the step (transfers that keep it) [m/s]
  bool finite = true;  // every node has a finite velocity

  void merge(const Ahead& o) {
    speed = std::max(speed, o.speed);
    spread = std::max(spread, o.spread);
    change = std::max(change, o.change);
    finite = finite && o.finite;
  }
};

}  // namespace neve
