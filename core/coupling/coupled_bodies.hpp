// The bodies of a run: the solids that forces move.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace neve {

// Velocity [m/s] and angular velocity [rad/s]; or impulse [N s] and moment [N m s].
using Twist = std::array<double, 6>;

// Bodies whose impulses move one another: joints or contacts join them. An impulse on any other body does not move them.
struct BodyGroup {
  std::vector<std::size_t> bodies;  // rising
  std::vector<double> mobility;     // A of dU = A dP, (6 k, 6 k) row by row [1/kg, ...]
};

// Where bodies are at the beginning of a step, and how they move in it.
struct BodyMotion {
  std::vector<std::array<double, 3>> centres;    // origins of their frames [m]
  std::vector<std::array<double, 9>> rotations;  // row by row, from their axes to those of the world
  std::vector<Twist> start;                      // velocities
  std::vector<Twist> free;                       // accelerations without the snow [m/s2, rad/s2]
  std::vector<BodyGroup> groups;                 // each body is in one

  std::size_t count() const { return start.size(); }
  // Hold n bodies at rest that nothing moves.
  void resize(std::size_t n) {
    centres.resize(n), rotations.resize(n), start.resize(n), free.resize(n), groups.clear();
    for (std::size_t i = 0; i < n; ++i) groups.push_back({{i}, std::vector<double>(36)});
  }
};

struct CoupledBodies : BodyMotion {
  std::vector<int> solids;  // index of each body's solid in the model
};

// The largest change of a body's velocity along an axis by a unit of impulse along it, and of its turning by one of moment.
struct LargestMobility {
  double moves = 0, turns = 0;  // [1/kg, 1/(kg m2)]
};
inline std::vector<LargestMobility> largest_mobility(const BodyMotion& bodies) {
  std::vector<LargestMobility> out(bodies.count());
  for (const BodyGroup& group : bodies.groups) {
    const std::size_t n = 6 * group.bodies.size();
    for (std::size_t k = 0; k < n; ++k) {
      LargestMobility& of = out[group.bodies[k / 6]];
      double& largest = k % 6 < 3 ? of.moves : of.turns;
      largest = std::max(largest, group.mobility[k * n + k]);
    }
  }
  return out;
}

}  // namespace neve
