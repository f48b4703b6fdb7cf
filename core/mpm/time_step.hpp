// What a pass over the particles reports: the rates that limit the next time step, and whether all is well.
#pragma once

#include <algorithm>
#include <cstdint>

namespace neve {

struct Report {
  double wave = 0;       // largest elastic wave speed c = sqrt(modulus V0 / m), hardened [m/s]
  double speed = 0;      // largest particle speed |v| [m/s]
  double fastest = 0;    // largest c + |v| [m/s]
  bool finite = true;    // every particle has finite x, v, F_E, J_P and stress
  bool drifted = false;  // some particle left its home's tile: sort before the next p2g

  void merge(const Report& o) {
    wave = std::max(wave, o.wave);
    speed = std::max(speed, o.speed);
    fastest = std::max(fastest, o.fastest);
    finite = finite && o.finite;
    drifted = drifted || o.drifted;
  }
};

}  // namespace neve
