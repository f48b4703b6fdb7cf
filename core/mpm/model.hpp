// Model: the constants of one run.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "constitutive/law.hpp"
#include "coupling/coupled_bodies.hpp"
#include "coupling/solid.hpp"
#include "heat/enthalpy.hpp"

namespace neve {

template <class T>
struct Model {
  double dx = 0.05;                    // [m]
  int spline = 0;                      // place in Splines
  int transfer = 0;                    // place in Transfers
  int polypic_modes = 8;               // 1, 4, 8 or 27
  double flip_alpha = 0.95;            // share of FLIP in a step
  std::optional<double> flip_damping;  // rate [1/s] at which what the grid cannot see fades, for flip_alpha
  Vec3<T> gravity{T(0), T(0), T(-9.81)};  // [m/s2]
  std::vector<Snow> snows;                // the material table
  bool has_elastic_snow = false;          // some of it does not flow
  std::vector<Solid<T>> solids;           // colliders and bodies; their poses change in time
  CoupledBodies bodies;                   // those of them that forces move

  double sleep_speed = 0;  // snow slower than this rests; 0: snow never sleeps [m/s]
  double sleep_after = 0;  // and sleeps when it has rested for so long [s]

  std::optional<HeatModel> heat{};  // what the scene says of it

  std::vector<std::shared_ptr<const void>> shapes{};  // what meshes and terrain of the solids point to

  bool sleeps() const { return sleep_speed > 0; }

  // The share of FLIP in a step of dt [s].
  double alpha(double dt) const { return flip_damping ? std::exp(-*flip_damping * dt) : flip_alpha; }
};

}  // namespace neve
