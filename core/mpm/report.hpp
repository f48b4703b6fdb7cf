// What the passes over nodes and particles report: the rates that limit the next time step, and whether all is well.
#pragma once

#include "math/compare.hpp"

namespace neve {

// Beyond these a step is not taken: it would carry a particle over more than a cell, or compress it to less than a
// twentieth of its volume, on the way to turning it inside out.
inline constexpr double displacement_limit = 1.0;   // [cells]
inline constexpr double volume_ratio_limit = 0.05;  // det(I + dt grad v) [1]

// What g2p found in the particles, or refresh() before the first step.
struct Report {
  static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

  double wave = 0;              // largest elastic wave speed c = sqrt(modulus V0 / m), hardened [m/s]
  double speed = 0;             // largest particle speed |v| [m/s]
  double fastest = 0;           // largest c + |v| [m/s]
  double strain_rate = 0;       // largest |grad v| (Frobenius) [1/s]
  double compression_rate = 0;  // largest -tr grad v [1/s]
  double max_displacement = 0;  // longest way of a particle in this step [cells]
  double min_volume_ratio = 1;  // smallest det(I + dt grad v) [1]
  double ice_room = std::numeric_limits<double>::infinity();  // smallest J over that of ice [1]
  bool finite = true;    // every particle has finite x, v, F_E, J_P and stress
  bool drifted = false;  // some particle left its home's tile: sort before the next p2g
  std::uint32_t offending_id =
      nobody;  // lowest birth number among the particles that make the step unacceptable

  bool rejected() const {
    return !finite || max_displacement > displacement_limit || min_volume_ratio < volume_ratio_limit;
  }

  void merge(const Report& o) {
    wave = max(o.wave, wave);
    speed = max(o.speed, speed);
    fastest = max(o.fastest, fastest);
    strain_rate = max(o.strain_rate, strain_rate);
    compression_rate = max(o.compression_rate, compression_rate);
    max_displacement = max(o.max_displacement, max_displacement);
    min_volume_ratio = min(o.min_volume_ratio, min_volume_ratio);
    ice_room = min(o.ice_room, ice_room);
    finite = finite && o.finite;
    drifted = drifted || o.drifted;
    offending_id = min(o.offending_id, offending_id);
  }
};

// What grid_update found in the nodes, before any particle is moved. Nodes lighter than a thousandth of the lightest
// particle are left out: 27 or 64 of them together have a small part in a particle's velocity.
struct GridReport {
  double speed = 0;                    // largest node speed [m/s]
  double max_velocity_difference = 0;  // largest difference of velocities within a home's tile [m/s]
  double max_velocity_change =
      0;               // largest change of a node's velocity in the step (transfers that keep it) [m/s]
  bool finite = true;  // every node has a finite velocity

  void merge(const GridReport& o) {
    speed = max(o.speed, speed);
    max_velocity_difference = max(o.max_velocity_difference, max_velocity_difference);
    max_velocity_change = max(o.max_velocity_change, max_velocity_change);
    finite = finite && o.finite;
  }
};

}  // namespace neve
