// Particles to grid: the driver of mass, momentum and force (Stomakhin et al. 2013, section 4.1, steps 1 and 3).
#pragma once

#include "cpu/fields.hpp"
#include "cpu/grid/scatter.hpp"
#include "cpu/lift.hpp"
#include "mpm/model.hpp"
#include "mpm/particle_update.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

// What a batch scatters, as quads per particle: one for each velocity mode, of which the first carries the mass.
template <class T, int Modes>
struct Carried {
  static constexpr int L = lane_count<T>;
  alignas(64) T mode[Modes][4 * L];

  void set(int k, const Vec3<Lanes<T>>& a, Lanes<T> last) { store_quads(mode[k], a.x, a.y, a.z, last); }
  // q and A. `shift`: what A does of itself is added to q where A then multiplies whole numbers alone.
  void set_affine(const Vec3<Lanes<T>>& q, Lanes<T> last, const Mat3<Lanes<T>>& A,
                  const Vec3<Lanes<T>>* shift) {
    const auto zero = splat<Lanes<T>>(0);
    set(0, shift ? q + A * *shift : q, last);
    set(1, A.c0, zero), set(2, A.c1, zero), set(3, A.c2, zero);
  }
};

template <class T, class Spline, int Q, int Modes>
NEVE_INLINE void scatter_affine(const Stencils<T, Spline, Q>& st, const Carried<T, Modes>& c, int count,
                                Scatter<T, Spline>& to) {
  for (int l = 0; l < count; ++l) {
    to.move_to(st.cell[l]);
    to.add(st, l, row_of_quad(c.mode[0] + 4 * l), row_of_quad(c.mode[1] + 4 * l),
           row_of_quad(c.mode[2] + 4 * l), row_of_quad(c.mode[3] + 4 * l));
  }
}
template <class T, class Spline, int Q, int Modes>
NEVE_INLINE void scatter_plain(const Stencils<T, Spline, Q>& st, const Carried<T, Modes>& c, int count,
                               Scatter<T, Spline>& to) {
  for (int l = 0; l < count; ++l) {
    to.move_to(st.cell[l]);
    to.add(st, l, row_of_quad(c.mode[0] + 4 * l));
  }
}
template <class T, class Spline, int Q, int Modes>
NEVE_INLINE void scatter_modes(const Stencils<T, Spline, Q>& st, const Carried<T, Modes>& c, int count,
                               Scatter<T, Spline>& to) {
  for (int l = 0; l < count; ++l) {
    to.move_to(st.cell[l]);
    to.add(st, l, c.mode);
  }
}

template <class Transfer, class T>
NEVE_INLINE void fetch_ahead(const State<T>& state, std::size_t p) {
  prefetch<Access::read>(state.x, p), prefetch<Access::read>(state.v, p);
  prefetch<Access::read>(state.m, p), prefetch<Access::read>(state.V0, p);
  prefetch<Access::read>(state.tau, p);
  if constexpr (Transfer::keeps_C) prefetch<Access::read>(state.C, p);
  prefetch<Access::read>(state.modes, p);
}

// `next`: the home that this thread is likely to come to after this one.
template <class T, class Spline, class Transfer>
void p2g_home(const Model<T>& model, const State<T>& state, Grid<T>& grid, const Home& home, const Home& next,
              double dt) {
  using R = Lanes<T>;
  Tile<T> tile, force;
  tile.clear();
  if constexpr (Transfer::has_change) force.clear();
  const auto step = StepConstants<T>::template of<Spline>(model.dx, dt, model.alpha(dt));
  const auto frame = TileFrame<T>::template of<Spline>(model.dx, home.at);
  Scatter<T, Spline> to(tile), to_force(force);
  using Weights = StoredWeights<typename Transfer::ScatterWeights, Transfer::modes>;
  Stencils<T, Spline, Weights::count> st;
  const Vec3<R>* shift = Weights::count == 1 ? &st.shift : nullptr;
  Carried<T, Transfer::modes> carried;
  for (std::uint32_t done = 0; done < home.count; done += width<R>) {
    const std::size_t p = home.begin + done;
    const int count = std::min<int>(width<R>, static_cast<int>(home.count - done));
    const std::uint32_t ahead = done + packs_ahead * width<R>;
    fetch_ahead<Transfer>(state, ahead < home.count ? home.begin + ahead : next.begin + (ahead - home.count));
    st.template fill<Weights>(frame, load_vector<R>(state.x, p, count));
    const R m = load<R>(state.m.column(0) + p, count), V0 = load<R>(state.V0.column(0) + p, count);
    const Contribution<R> given =
        contribution<Transfer>(load_vector<R>(state.v, p, count), m, load_matrix<R>(state.C, p, count),
                               load_symmetric<R>(state.tau, p, count), V0, step);
    if constexpr (Transfer::has_matrix)
      carried.set_affine(given.momentum, given.mass, given.A, shift);
    else
      carried.set(0, given.momentum, given.mass);
    if constexpr (Transfer::modes > 4) {
      for (int k = 4; k < Transfer::modes; ++k)
        carried.set(k, load_vector<R>(state.modes, p, count, 3 * (k - 4)) * m, splat<R>(0));
      scatter_modes(st, carried, count, to);
    } else if constexpr (Transfer::has_matrix) {
      scatter_affine(st, carried, count, to);
    } else {
      scatter_plain(st, carried, count, to);
    }
    if constexpr (Transfer::has_change) {
      carried.set_affine(Vec3<R>{}, R{},
                         Transfer::force(load_symmetric<R>(state.tau, p, count), V0, step.cells), shift);
      scatter_affine(st, carried, count, to_force);
    }
  }
  to.flush();
  tile.add_to(grid, home, &Grid<T>::node);
  if constexpr (Transfer::has_change) {
    to_force.flush();
    force.add_to(grid, home, &Grid<T>::node_change);
  }
}

}  // namespace detail

// Fill the grid from the particles. Eight passes, one per colour of home: within a pass no two tiles share a node,
// and the order in which a node receives its sums is that of the colours, whatever the threads do.
template <class T, class Spline, class Transfer>
void p2g(const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt) {
#if defined(_OPENMP)
#pragma omp parallel
#endif
  {
    const auto blocks = static_cast<std::int64_t>(grid.blocks.size());
    const std::int64_t threads = thread_count();
#if defined(_OPENMP)
#pragma omp for schedule(static)
#endif
    for (std::int64_t b = 0; b < blocks; ++b) {
      std::memset(grid.node(static_cast<std::int32_t>(b)), 0, block_values * sizeof(T));
      if constexpr (Transfer::has_change) {
        std::memset(grid.node_change(static_cast<std::int32_t>(b)), 0, block_values * sizeof(T));
      }
      if (grid.has_lift || grid.has_water)
        std::memset(grid.node_lift(static_cast<std::int32_t>(b)), 0, block_values * sizeof(T));
    }
    for (const auto& colour : grid.colours) {
      const auto homes = static_cast<std::int64_t>(colour.size());
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 1)
#endif
      for (std::int64_t k = 0; k < homes; ++k) {
        const Home& home = grid.homes[static_cast<std::size_t>(colour[static_cast<std::size_t>(k)])];
        const auto after = static_cast<std::size_t>(std::min(k + threads, homes - 1));
        const Home& next = grid.homes[static_cast<std::size_t>(colour[after])];
        detail::p2g_home<T, Spline, Transfer>(model, state, grid, home, next, dt);
        if (grid.has_lift || grid.has_water) scatter_lift<T, Spline>(model, state, grid, home);
      }
    }
  }
}

}  // namespace neve
