// Which solids a patch of nodes can meet.
#pragma once

#include <vector>

#include "cpu/grid/blocks.hpp"
#include "mpm/model.hpp"

namespace neve {

template <class T>
Vec3<T> node_position(const Model<T>& model, BlockCoord at, int i, int j, int k) {
  const auto dx = static_cast<T>(model.dx);
  return {T(4 * at.x + i) * dx, T(4 * at.y + j) * dx, T(4 * at.z + k) * dx};
}

// The solids whose surface may lie within `reach` [cells] of the point that lies `half` [cells] from a block's first node
// along each axis.
template <class T>
std::vector<Solid<T>> solids_near_nodes(const Model<T>& model, BlockCoord at, double half, double reach) {
  const auto dx = static_cast<T>(model.dx);
  const Vec3<T> corner = node_position(model, at, 0, 0, 0), middle{T(half) * dx, T(half) * dx, T(half) * dx};
  std::vector<Solid<T>> near;
  for (const Solid<T>& solid : model.solids) {
    if (is_near(solid, corner + middle, T(reach) * dx)) near.push_back(solid);
  }
  return near;
}

// What solids are to water: nothing holds it to them, and they do not rub it.
template <class T>
std::vector<Solid<T>> smooth(std::vector<Solid<T>> solids) {
  for (Solid<T>& solid : solids) solid.mode = ContactMode::separate, solid.mu_c = T(0);
  return solids;
}

}  // namespace neve
