// The energy of a particle's velocity modes, from values to values.
#pragma once

#include "math/bspline.hpp"
#include "transfer/weights.hpp"

namespace neve {

// Kinetic energy per mass of all velocity modes but the first [J/kg]: 1/2 sum_r <s_r, s_r> |c_r|^2 with <s, s> = sum_i w_ip
// s^2. `C` gives the nine parts of dx C [m/s], `fraction` where the particle is along each axis between two nodes, and
// mode(3 (n - 4) + k) part k of mode n [m/s].
template <class Spline, class Transfer, class F>
double modes_energy(const double (&C)[9], const double (&fraction)[3], F&& mode) {
  double sum = 0;
  for (double c : C) sum += c * c / Spline::inverse_inertia;
  if constexpr (Transfer::modes > 4) {
    double norm[3][3];  // of each axis and degree
    for (int a = 0; a < 3; ++a)
      norm[a][0] = 1, norm[a][1] = 1 / Spline::inverse_inertia, norm[a][2] = square_norm<Spline>(fraction[a]);
    for (int n = 4; n < Transfer::modes; ++n) {
      double own = 1;
      for (int a = 0; a < 3; ++a) own *= norm[a][Transfer::order[n].degree[a]];
      for (int k = 0; k < 3; ++k) {
        const double c = mode(3 * (n - 4) + k);
        sum += own * c * c;
      }
    }
  }
  return 0.5 * sum;
}

}  // namespace neve
