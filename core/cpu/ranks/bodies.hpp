// Bodies in a run on several ranks: each rank has them, and finds their velocities from the nodes of all ranks near them.
#pragma once

#include <algorithm>

#include "cpu/grid_update.hpp"

namespace neve {

// Node blocks near bodies: their keys, and the values of their nodes, momentum and, if there is any, lift.
template <class T>
struct BlocksNearBodies {
  std::vector<BlockKey> keys;
  std::vector<T> values;
};

namespace detail {

// How many arrays of a block contacts follow from.
template <class T>
std::size_t contact_layers(const Grid<T>& grid) {
  return 1 + std::size_t(grid.has_lift);
}

// The solids near a block if there are bodies among them, none otherwise.
template <class T>
std::vector<NearSolid<T>> near_with_bodies(const BlockUpdate<T>& update, BlockCoord at) {
  auto near = solids_near_block(update.model, update.balls, at);
  const auto is_body = [](const NearSolid<T>& solid) { return solid.body >= 0; };
  if (std::none_of(near.begin(), near.end(), is_body)) near.clear();
  return near;
}

}  // namespace detail

// grid_update up to contacts with bodies; the blocks near those, of which no lower rank has the same.
template <class T>
BlocksNearBodies<T> update_nodes(Model<T>& model, Grid<T>& grid, double dt) {
  const detail::BlockUpdate<T> update(model, dt, grid.has_change);
  const detail::NearBlocks<T> near = detail::update_blocks(grid, update);
  BlocksNearBodies<T> out;
  for (std::size_t b = 0; b < near.size(); ++b) {
    if (near[b].empty() || !grid.halo.counted[b]) continue;
    const auto block = static_cast<std::int32_t>(b);
    out.keys.push_back(key_of(grid.blocks[b]));
    out.values.insert(out.values.end(), grid.node(block), grid.node(block) + block_values);
    if (grid.has_lift)
      out.values.insert(out.values.end(), grid.node_lift(block), grid.node_lift(block) + block_values);
  }
  return out;
}

// The rest of grid_update, given the blocks near bodies of all ranks by rising key.
template <class T>
GridReport meet_bodies(Model<T>& model, Grid<T>& grid, double dt, const BlocksNearBodies<T>& of_all) {
  const detail::BlockUpdate<T> update(model, dt, grid.has_change);
  const std::size_t layers = detail::contact_layers(grid);
  Grid<T> all;
  all.has_lift = grid.has_lift;
  all.momentum.resize(of_all.keys.size() * block_values);
  if (all.has_lift) all.lift.resize(of_all.keys.size() * block_values);
  detail::NearBlocks<T> near, mine;
  for (std::size_t b = 0; b < of_all.keys.size(); ++b) {
    const auto block = static_cast<std::int32_t>(b);
    const T* values = of_all.values.data() + b * layers * block_values;
    std::copy_n(values, block_values, all.node(block));
    if (all.has_lift) std::copy_n(values + block_values, block_values, all.node_lift(block));
    all.blocks.push_back(coord_of(of_all.keys[b]));
    near.push_back(detail::near_with_bodies(update, all.blocks.back()));
  }
  const std::vector<Twist> U =
      detail::body_velocities(model, all, detail::find_contacts(all, update, near), dt);
  for (BlockCoord at : grid.blocks) mine.push_back(detail::near_with_bodies(update, at));
  const std::size_t count = detail::find_contacts(grid, update, mine);
  detail::meet_bodies(model, grid, update, count, U);
  return detail::grid_report_of(grid);
}

}  // namespace neve
