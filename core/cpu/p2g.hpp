// Particles to grid: the driver of mass, momentum and force (Stomakhin et al. 2013, section 4.1, steps 1 and 3).
#pragma once

#include "cpu/fields.hpp"
#include "cpu/grid/scatter.hpp"
#include "cpu/lift.hpp"
#include "cpu/way.hpp"
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
                  const Vec3<Lanes<T>>* shift = nullptr) {
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
  prefetch<Access::read>(state.modes, p), prefetch<Access::read>(state.beyond, p);
}

// Copy a tile, block by block.
template <class T>
void keep(Tile<T>& tile, T* kept) {
  Home all{};
  for (int k = 0; k < 8; ++k) all.nodes[std::size_t(k)] = k;
  tile.each_row(
      all, [](T* mine, T* to) { std::memcpy(to, mine, 16 * sizeof(T)); },
      [&](std::int32_t k) { return kept + std::size_t(k) * block_values; });
}

// Add the values of a block to others.
template <class T>
void add_block(const T* values, T* to) {
  for (int k = 0; k < block_values; k += 16)
    store_row<T>(to + k, load_row<T>(to + k) + load_row<T>(values + k));
}

// Add what a home of the border has kept, as its tile would have been added.
template <class T>
void add_kept(Grid<T>& grid, std::int32_t home) {
  const auto at = std::size_t(grid.halo.kept_of[std::size_t(home)]) * std::size_t(grid.layers());
  for (int layer = 0; layer < grid.layers(); ++layer) {
    const T* kept = grid.halo.kept.data() + (at + std::size_t(layer)) * 8 * block_values;
    for (std::size_t k = 0; k < 8; ++k)
      add_block(kept + k * block_values, grid.layer(layer, grid.homes[std::size_t(home)].nodes[k]));
  }
}

// Add what a home of another rank gives to a node block.
template <class T>
void add_taken(Grid<T>& grid, std::int32_t row) {
  const auto layers = std::size_t(grid.layers());
  for (std::size_t layer = 0; layer < layers; ++layer) {
    const T* values = grid.halo.received.data() + (std::size_t(row) * layers + layer) * block_values;
    add_block(values, grid.layer(int(layer), grid.halo.taken[std::size_t(row)]));
  }
}

// What a home gives to its nodes: momentum, mass and, of transfers that keep them apart, force.
template <class T, class Spline, class Transfer>
class HomeScatter {
  using R = Lanes<T>;
  static constexpr int L = width<R>;
  using Weights = StoredWeights<typename Transfer::ScatterWeights, Transfer::modes>;
  static constexpr bool affine = Weights::count == 1;

 public:
  // `next`: the home that this thread is likely to come to after this one.
  HomeScatter(const Model<T>& model, const State<T>& state, const Home& home, const Home& next, double dt)
      : state_(state),
        home_(home),
        next_(next),
        step_(StepConstants<T>::template of<Spline>(model.dx, dt, model.alpha(dt))),
        frame_(TileFrame<T>::template of<Spline>(model.dx, home.at)) {
    tile_.clear();
    if constexpr (Transfer::has_change) force_.clear();
  }

  void add_to(Grid<T>& grid) {
    scatter_all();
    tile_.add_to(grid, home_, &Grid<T>::node);
    if constexpr (Transfer::has_change) force_.add_to(grid, home_, &Grid<T>::node_change);
  }
  // Keep the sums for themselves: the eight blocks of the tile, of each layer.
  void keep_in(T* kept) {
    scatter_all();
    detail::keep(tile_, kept);
    if constexpr (Transfer::has_change) detail::keep(force_, kept + 8 * block_values);
  }

 private:
  NEVE_APART void scatter_all() {
    if constexpr (affine) {
      for (std::uint32_t done = 0; done < home_.count; done += Batch::capacity)
        scatter_batch(done, std::min<int>(Batch::capacity, static_cast<int>(home_.count - done)));
    } else {
      scatter_packs();
    }
  }

  // So many particles that few cells are cut by the end of a batch.
  using Batch = AffineBatch<T, Spline, 64>;

  // The columns of a pack. (Lanes beyond the home's particles hold what lies there; nobody scatters them.)
  struct Pack {
    const State<T>& state;
    std::size_t p;
    Vec3<R> vector(const Columns<T>& f, int first = 0) const { return load_vector<R>(f, p, L, first); }
    Vec3<R> way(const TileFrame<T>& frame) const { return load_way<R>(state, frame, p, L); }
    R number(const Field<T, 1>& f) const { return load<R>(f.column(0) + p); }
    Sym3<R> tau() const { return load_symmetric<R>(state.tau, p, L); }
    Contribution<R> contribution(const StepConstants<T>& step) const {
      return neve::contribution<Transfer>(vector(state.v), number(state.m), load_matrix<R>(state.C, p, L),
                                          tau(), number(state.V0), step);
    }
  };

  void fetch_ahead(std::uint32_t done) const {
    if (done % line_particles<T> != 0) return;
    const std::uint32_t ahead = done + lines_ahead * line_particles<T>;
    detail::fetch_ahead<Transfer>(
        state_, ahead < home_.count ? home_.begin + ahead : next_.begin + (ahead - home_.count));
  }

  void scatter_batch(std::uint32_t done, int count) {
    Vec3<R> shift[Batch::capacity / L];
    for (int l = 0; l < count; l += L) {
      fetch_ahead(done + static_cast<std::uint32_t>(l));
      const Pack pack{state_, home_.begin + done + static_cast<std::uint32_t>(l)};
      const Vec3<R> way = shift[l / L] = batch_.place(l, frame_, pack.way(frame_));
      const Contribution<R> given = pack.contribution(step_);
      batch_.give(l, given.momentum, given.mass, given.A, way);
    }
    scatter(batch_, count, tile_);
    if constexpr (Transfer::has_change) {
      for (int l = 0; l < count; l += L) {
        const Pack pack{state_, home_.begin + done + static_cast<std::uint32_t>(l)};
        batch_.give(l, Vec3<R>{}, R{}, Transfer::force(pack.tau(), pack.number(state_.V0), step_.cells),
                    shift[l / L]);
      }
      scatter(batch_, count, force_);
    }
  }

  void scatter_packs() {
    Scatter<T, Spline> to(tile_), to_force(force_);
    Stencils<T, Spline, Weights::count> st;
    Carried<T, Transfer::modes> carried;
    for (std::uint32_t done = 0; done < home_.count; done += L) {
      const int count = std::min<int>(L, static_cast<int>(home_.count - done));
      fetch_ahead(done);
      const Pack pack{state_, home_.begin + done};
      st.template fill<Weights>(frame_, pack.way(frame_));
      const Contribution<R> given = pack.contribution(step_);
      if constexpr (Transfer::has_matrix)
        carried.set_affine(given.momentum, given.mass, given.A);
      else
        carried.set(0, given.momentum, given.mass);
      if constexpr (Transfer::modes > 4) {
        for (int k = 4; k < Transfer::modes; ++k)
          carried.set(k, pack.vector(state_.modes, 3 * (k - 4)) * given.mass, splat<R>(0));
        scatter_modes(st, carried, count, to);
      } else if constexpr (Transfer::has_matrix) {
        scatter_affine(st, carried, count, to);
      } else {
        scatter_plain(st, carried, count, to);
      }
      if constexpr (Transfer::has_change) {
        carried.set_affine(Vec3<R>{}, R{}, Transfer::force(pack.tau(), pack.number(state_.V0), step_.cells));
        scatter_affine(st, carried, count, to_force);
      }
    }
    to.flush();
    if constexpr (Transfer::has_change) to_force.flush();
  }

  const State<T>& state_;
  const Home &home_, &next_;
  StepConstants<T> step_;
  TileFrame<T> frame_;
  Tile<T> tile_, force_;
  Batch batch_;
};

}  // namespace detail

// Scatter the particles of homes at a border, and lay ready what other ranks are to be given. Call before p2g.
template <class T, class Spline, class Transfer>
void give(const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt) {
  Halo<T>& halo = grid.halo;
  const auto layers = std::size_t(grid.layers());
  each_index(halo.border.size(), [&](std::size_t k) {
    const Home& home = grid.homes[std::size_t(halo.border[k])];
    T* kept = halo.kept.data() + k * layers * 8 * block_values;
    detail::HomeScatter<T, Spline, Transfer>(model, state, home, home, dt).keep_in(kept);
    if (grid.has_lift || grid.has_water) {
      Tile<T> tile;
      scatter_lift<T, Spline>(model, state, grid, home, tile);
      detail::keep(tile, kept + (layers - 1) * 8 * block_values);
    }
  });
  each_index(halo.given.size(), [&](std::size_t row) {
    const auto k = std::size_t(halo.given[row]);
    for (std::size_t layer = 0; layer < layers; ++layer) {
      const T* kept = halo.kept.data() + ((k / 8 * layers + layer) * 8 + k % 8) * block_values;
      std::memcpy(halo.sent.data() + (row * layers + layer) * block_values, kept, block_values * sizeof(T));
    }
  });
}

namespace detail {

// A home's turn in p2g: scatter its particles, unless that is done already.
template <class T, class Spline, class Transfer>
void scatter_home(const Model<T>& model, const State<T>& state, Grid<T>& grid, const Home& home,
                  const Home& next, double dt) {
  const auto h = static_cast<std::int32_t>(&home - grid.homes.data());
  if (grid.halo.keeps(h)) {
    add_kept(grid, h);
    return;
  }
  HomeScatter<T, Spline, Transfer>(model, state, home, next, dt).add_to(grid);
  if (!grid.has_lift && !grid.has_water) return;
  Tile<T> tile;
  scatter_lift<T, Spline>(model, state, grid, home, tile);
  tile.add_to(grid, home, &Grid<T>::node_lift);
}

}  // namespace detail

// Fill the grid from the particles. A node receives its sums in one order, whatever the threads do (see Turns). Homes of other
// ranks take part by what they have given.
template <class T, class Spline, class Transfer>
void p2g(const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt) {
  each_index(grid.blocks.size(), [&](std::size_t b) {
    for (int layer = 0; layer < grid.layers(); ++layer)
      std::memset(grid.layer(layer, static_cast<std::int32_t>(b)), 0, block_values * sizeof(T));
  });
  std::vector<Shares> taken;
  for (const auto& rows : grid.halo.taken_of) taken.emplace_back(rows.size());
  grid.turns.each(
      grid.homes,
      [&](const Home& home, const Home& next) {
        detail::scatter_home<T, Spline, Transfer>(model, state, grid, home, next, dt);
      },
      [&](std::size_t colour) {
        taken[colour].work([&](std::size_t k) { detail::add_taken(grid, grid.halo.taken_of[colour][k]); });
      });
}

}  // namespace neve
