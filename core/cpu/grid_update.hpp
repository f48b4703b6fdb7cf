// Grid: the driver of velocities, gravity, forces, and collisions over all blocks, and of the bodies that the snow moves.
#pragma once

#include "cpu/block_update.hpp"
#include "mpm/report.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

// Let the snow of the waiting blocks and the bodies find their common velocities.
template <class T>
void solve_bodies(Model<T>& model, Grid<T>& grid, const BlockUpdate<T>& update,
                  const std::vector<char>& waits, double dt) {
  std::size_t count = 0;
  for (std::size_t b = 0; b < waits.size(); ++b) {
    if (!waits[b]) continue;
    if (grid.contacts.size() == count) grid.contacts.emplace_back();
    grid.contacts[count++].clear(static_cast<std::int32_t>(b));
  }
  each_index(count, [&](std::size_t k) { update.find_contacts(grid, grid.contacts[k]); });
  Responses<T> responses(grid.contacts, count, model.bodies.solids.size());
  const std::vector<Twist> U =
      BodyVelocitySolver(model.bodies, dt).solve([&](const auto& U_now) { return responses.to(U_now); });
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

}  // namespace detail

// Turn momenta into velocities at the end of the step, and look at what they would do to the particles. Bodies
// get the velocities that they will have then.
template <class T>
GridReport grid_update(Model<T>& model, Grid<T>& grid, double dt) {
  const detail::BlockUpdate<T> update(model, dt, grid.has_change);
  const auto blocks = static_cast<std::int64_t>(grid.blocks.size());
  std::vector<char> waits(grid.blocks.size());
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 8)
#endif
  for (std::int64_t b = 0; b < blocks; ++b)
    waits[static_cast<std::size_t>(b)] = update.block(grid, static_cast<std::int32_t>(b));
  if (!model.bodies.solids.empty()) detail::solve_bodies(model, grid, update, waits, dt);
  return merge_each<GridReport>(grid.moving,
                                [&](std::size_t h) { return detail::grid_report_of(grid, grid.homes[h]); });
}

}  // namespace neve
