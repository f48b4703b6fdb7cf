// Model: the constants of one run.
#pragma once

#include <vector>

#include "colliders/analytic.hpp"
#include "constitutive/law.hpp"

namespace neve {

enum class Spline { quadratic, cubic };
enum class Transfer { apic, flip };

template <class T>
struct Model {
  double dx = 0.05;  // [m]
  Spline spline = Spline::quadratic;
  Transfer transfer = Transfer::apic;
  double flip_alpha = 0.95;
  Vec3<T> gravity{T(0), T(0), T(-9.81)};  // [m/s2]
  std::vector<Snow> snows;                // the material table
  std::vector<Solid<T>> solids;           // colliders; their poses change in time
};

}  // namespace neve
