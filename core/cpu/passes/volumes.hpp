// Rest volumes from the density of the grid.
#pragma once

#include "cpu/each_batch.hpp"
#include "cpu/grid/gather.hpp"
#include "threads.hpp"

namespace neve {

// Stomakhin et al. 2013, section 4.1, step 2: rho_p = sum_i m_i w_ip / dx^3, V0_p = m_p / rho_p. Call after p2g.
template <class T, class Spline>
void volumes_from_grid(const Model<T>& model, State<T>& state, Grid<T>& grid) {
  const T cell = static_cast<T>(model.dx * model.dx * model.dx);
  each_index(grid.moving, [&](std::size_t h) {
    const Home& home = grid.homes[h];
    Tile<T> tile;
    tile.load_from(grid, home, &Grid<T>::node);
    Gather<T, Spline> from(tile);
    detail::each_batch<T, Spline>(model, state, home, [&](std::size_t p, int count, const auto& st) {
      for (int l = 0; l < count; ++l) {
        const T mass_per_cell = from.sum(st, l)[3];
        state.V0.column(0)[p + static_cast<std::size_t>(l)] =
            state.m.column(0)[p + static_cast<std::size_t>(l)] * cell / mass_per_cell;
      }
    });
  });
}

}  // namespace neve
