// How far snow has left surfaces with play, and how much of it is water, between particles and nodes.
#pragma once

#include "cpu/each_batch.hpp"
#include "cpu/grid/gather.hpp"
#include "cpu/grid/scatter.hpp"
#include "cpu/wet.hpp"
#include "mpm/dispatch.hpp"
#include "threads.hpp"

namespace neve {

// (m s)_i = sum_p w_ip m_p s_p of a home in its tile, and (m f)_i of the shares of water; s is in `modes`, from column `first`.
template <class T, class Spline>
void scatter_lift(const Model<T>& model, const State<T>& state, const Grid<T>& grid, const Home& home,
                  Tile<T>& tile) {
  using R = Lanes<T>;
  const int first = 3 * more_modes(model);
  tile.clear();
  Scatter<T, Spline> to(tile);
  detail::each_batch<T, Spline>(model, state, home, [&](std::size_t p, int count, const auto& st) {
    const R m = load<R>(state.m.column(0) + p, count);
    const Vec3<R> ms = grid.has_lift ? load_vector<R>(state.modes, p, count, first) * m : Vec3<R>{};
    alignas(64) T quads[4 * width<R>];
    store_quads(quads, ms.x, ms.y, ms.z, grid.has_water ? R(m * detail::liquid_share(state, p, count)) : R{});
    for (int l = 0; l < count; ++l) {
      to.move_to(st.cell[l]);
      to.add(st, l, row_of_quad(quads + 4 * l));
    }
  });
  to.flush();
}

// s_p += sum_i w_ip (change of s_i). Call before the particles move.
template <class T, class Spline>
void gather_lift(const Model<T>& model, State<T>& state, Grid<T>& grid) {
  using R = Lanes<T>;
  const int first = 3 * more_modes(model);
  each_index(grid.moving, [&](std::size_t h) {
    Tile<T> tile;
    tile.load_from(grid, grid.homes[h], &Grid<T>::node_lift);
    const Gather<T, Spline> from(tile);
    detail::each_batch<T, Spline>(model, state, grid.homes[h], [&](std::size_t p, int count, const auto& st) {
      alignas(64) T quads[4 * width<R>] = {};
      for (int l = 0; l < count; ++l) store_quad<T>(quads + 4 * l, from.sum(st, l), 0);
      Vec3<R> change;
      R unused;
      load_quads(quads, change.x, change.y, change.z, unused);
      store_vector(state.modes, p, load_vector<R>(state.modes, p, count, first) + change, count, first);
    });
  });
}

}  // namespace neve
