// What a solid says of a point: how far its surface is, and which way is out.
#pragma once

#include "math/mat3.hpp"

namespace neve {

// Signed distance phi [m] (negative inside) and its gradient, the outward unit normal.
template <class R>
struct Surface {
  R phi;
  Vec3<R> normal;
};

}  // namespace neve
