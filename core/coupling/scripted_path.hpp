// How a script moves a solid: by legs, each straight at a constant velocity and with a constant rate of turn.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace neve {

struct ScriptedLeg {
  double begin, span;              // [s]
  std::array<double, 3> position;  // at the beginning [m]
  std::array<double, 9> rotation;  // then, row by row, from the solid's axes to those of the world
  std::array<double, 3> way;       // in the whole leg [m]
  std::array<double, 3> axis;      // unit vector about which it turns in the leg,
  double angle;                    // and by how much [rad]
  std::array<double, 3> velocity;  // [m/s]
  std::array<double, 3> omega;     // [rad/s]
};

// Where a solid's frame is and how it moves, in the units of a leg.
struct ScriptedPose {
  std::array<double, 3> position;
  std::array<double, 9> rotation;
  std::array<double, 3> velocity, omega;
};

// Evaluated without fused multiplication and addition: the same bits with every instruction set.
class ScriptedPath {
 public:
  // Leg i + 1 begins at starts[i], which rise; the first leg holds before. There is one leg more than starts.
  ScriptedPath(std::vector<double> starts, std::vector<ScriptedLeg> legs)
      : starts_(std::move(starts)), legs_(std::move(legs)) {}
  ScriptedPose at(double t) const;

 private:
  std::vector<double> starts_;
  std::vector<ScriptedLeg> legs_;
};

// The unit quaternion w x y z, w >= 0, of a rotation, read from its largest component (Shepperd 1978).
std::array<double, 4> quaternion_of(const std::array<double, 9>& rotation);

}  // namespace neve
