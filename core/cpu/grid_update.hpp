// Grid: the driver of velocities, gravity, forces, and collisions over all blocks, and of the bodies that the snow moves.
#pragma once

#include "cpu/block_update.hpp"
#include "mpm/report.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

// Of each block that waits for bodies the solids near it; of others none.
template <class T>
using NearBlocks = std::vector<std::vector<NearSolid<T>>>;

// All of the blocks but their contacts with bodies.
template <class T>
NEVE_APART NearBlocks<T> update_blocks(Grid<T>& grid, const BlockUpdate<T>& update) {
  NearBlocks<T> near(grid.blocks.size());
  each_index(near.size(), [&](std::size_t b) { near[b] = update.block(grid, static_cast<std::int32_t>(b)); });
  return near;
}

// Collect in grid.contacts those of the waiting blocks, and return how many blocks wait.
template <class T>
NEVE_APART std::size_t find_contacts(Grid<T>& grid, const BlockUpdate<T>& update, const NearBlocks<T>& near) {
  std::size_t count = 0;
  for (std::size_t b = 0; b < near.size(); ++b) {
    if (near[b].empty()) continue;
    if (grid.contacts.size() == count) grid.contacts.emplace_back();
    grid.contacts[count++].clear(static_cast<std::int32_t>(b));
  }
  each_index(count, [&](std::size_t k) {
    BlockContacts<T>& contacts = grid.contacts[k];
    update.find_contacts(grid, near[std::size_t(contacts.block)], contacts);
  });
  return count;
}

// The velocities of the bodies that the snow of the waiting blocks and they find together.
template <class T>
NEVE_APART std::vector<Twist> body_velocities(const Model<T>& model, const Grid<T>& grid, std::size_t count,
                                              double dt) {
  Responses<T> responses(grid.contacts, count, model.bodies.solids.size());
  return BodyVelocitySolver(model.bodies, dt).solve([&](const auto& now, bool slopes) {
    return responses.to(now, slopes);
  });
}

// Let the snow of the waiting blocks and the bodies move with these.
template <class T>
NEVE_APART void meet_bodies(Model<T>& model, Grid<T>& grid, const BlockUpdate<T>& update, std::size_t count,
                            const std::vector<Twist>& U) {
  each_index(count, [&](std::size_t k) { update.apply(grid, grid.contacts[k], U); });
  set_velocities(model.bodies, U, model.solids);
}

// The differences of velocity that a home's particles can see.
template <class T>
GridReport grid_report_of(const Grid<T>& grid, const Home& home) {
  constexpr T far = std::numeric_limits<T>::max();
  Vec3<T> low{far, far, far}, high{-far, -far, -far};
  GridReport out;
  for (std::int32_t b : home.nodes) {
    const BlockBounds<T>& bounds = grid.bounds[static_cast<std::size_t>(b)];
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], bounds.low[k]);
      high[k] = std::max(high[k], bounds.high[k]);
    }
    out.max_velocity_change =
        std::max(out.max_velocity_change, std::sqrt(3.0) * static_cast<double>(bounds.change));
    out.finite = out.finite && bounds.finite;
  }
  double difference2 = 0, speed2 = 0;
  for (int k = 0; k < 3; ++k) {
    const double l = low[k], h = high[k];
    difference2 += (h - l) * (h - l);
    speed2 += std::max(l * l, h * h);
  }
  out.max_velocity_difference = std::sqrt(difference2);
  out.speed = std::sqrt(speed2);
  return out;
}

// Those of all homes that move.
template <class T>
NEVE_APART GridReport grid_report_of(const Grid<T>& grid) {
  return merge_each<GridReport>(grid.moving,
                                [&](std::size_t h) { return grid_report_of(grid, grid.homes[h]); });
}

}  // namespace detail

// Turn momenta into velocities at the end of the step, and look at what they would do to the particles. Bodies
// get the velocities that they will have then.
template <class T>
GridReport grid_update(Model<T>& model, Grid<T>& grid, double dt) {
  const detail::BlockUpdate<T> update(model, dt, grid.has_change);
  const detail::NearBlocks<T> near = detail::update_blocks(grid, update);
  if (!model.bodies.solids.empty()) {
    const std::size_t count = detail::find_contacts(grid, update, near);
    detail::meet_bodies(model, grid, update, count, detail::body_velocities(model, grid, count, dt));
  }
  return detail::grid_report_of(grid);
}

}  // namespace neve
