// The bodies of a run: the solids that forces move.
#pragma once

#include <array>
#include <vector>

namespace neve {

// Velocity [m/s] and angular velocity [rad/s]; or impulse [N s] and moment [N m s].
using Twist = std::array<double, 6>;

// Rows of the model's solids, in order, and how impulses change their velocities.
struct CoupledBodies {
  std::vector<int> solids;       // index of each body's solid in the model
  std::vector<double> mobility;  // A, (6 n, 6 n) row by row [1/kg, ...]
  std::vector<Twist> free;       // acceleration without the snow [m/s2, rad/s2]
  std::vector<Twist> start;      // velocities at the beginning of the step
};

}  // namespace neve
