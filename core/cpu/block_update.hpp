// Grid: the driver of velocities, gravity, forces and collisions in one block of nodes (Stomakhin et al. 2013, section
// 4.1, steps 4 to 6, explicit). What happens to a node is in mpm/node_update.hpp and coupling/.
#pragma once

#include <limits>

#include "coupling/body_solver.hpp"
#include "cpu/grid/grid.hpp"
#include "cpu/near.hpp"
#include "math/rows.hpp"
#include "mpm/node_update.hpp"

namespace neve::detail {

template <class T>
struct BlockUpdate {
  const Model<T>& model;
  SolidBalls<T> balls;
  T dt;
  bool has_change;
  Row<T> gravity_step;  // dt g, 0

  BlockUpdate(const Model<T>& m, double step, bool change)
      : model(m), balls(m), dt(T(step)), has_change(change) {
    const T quad[4] = {m.gravity.x * dt, m.gravity.y * dt, m.gravity.z * dt, T(0)};
    gravity_step = row_of_quad(quad);
  }

  // A row of four nodes: momenta become velocities at the end of the step, forces their changes. Nodes without a velocity
  // stay zero.
  void row(T* node, T* change) const {
    const Row<T> a = load_row<T>(node);
    const Row<T> m = last_of_quads<T>(a);
    const auto full = has_velocity(m);
    const Row<T> inverse_m = inverse_mass(m);
    const Row<T> mass = mass_only(m);
    Row<T> step = gravity_step;
    if (has_change) {
      step = velocity_change(gravity_step, load_row<T>(change), inverse_m, dt);
      store_row<T>(change, select(full, step, Row<T>{}));
    }
    store_row<T>(node, select(full, select(is_mass(), mass, node_velocity(a, inverse_m, step)), Row<T>{}));
  }

  // Solids near a block, as they are to snow and as they are to water.
  struct Near {
    const std::vector<NearSolid<T>>&to_snow, &to_water;
  };

  // Let the near solids act on a batch of nodes from the block's `first`; the change keeps what they did. `water`: (m f) of
  // the nodes, if there may be some.
  void collide_nodes(const Near& near, int first, T* node, T* change, T* lift, const T* water,
                     ExchangeSum& exchange) const {
    using R = Lanes<T>;
    Vec3<R> v;
    R mass;
    load_quads(node, v.x, v.y, v.z, mass);
    const Vec3<R> x = ways(first);
    const R wet = water ? wet_mass(water, mass) : R{};
    const auto act = [&](const std::vector<NearSolid<T>>& solids, const Vec3<R>& before, auto& left,
                         const R& m) {
      return collide(solids, x, before, left, skin(), dt, m,
                     [&](const auto& solid, const auto& inside, const auto&... exchanged) {
                       record(exchange.of(solid.index), inside, mass, exchanged...);
                     });
    };
    const auto after = [&](auto& left) {
      Vec3<R> now = act(near.to_snow, v, left, R(mass - wet));
      if (any(wet > R{})) now = act(near.to_water, now, left, wet);
      return now;
    };
    if (lift) {
      Lift<Lanes<T>> left = load_lift(lift, mass);
      const Vec3<Lanes<T>> before = left.s;
      store_nodes(node, change, v, after(left), mass);
      store_lift(lift, left.s - before);
    } else {
      NoLift none;
      store_nodes(node, change, v, after(none), mass);
    }
  }

  // The mass of nodes that are water for the most part, zero of others.
  static Lanes<T> wet_mass(const T* water, const Lanes<T>& mass) {
    Lanes<T> unused, liquid;
    load_quads(water, unused, unused, unused, liquid);
    return select(liquid > mass * T(0.5), mass, Lanes<T>{});
  }

  // How far a batch of nodes has left surfaces with play, from m s; none if there is no such surface.
  Lift<Lanes<T>> load_lift(const T* lift, Lanes<T> mass) const {
    Lift<Lanes<T>> left{{}, dt, T(play_cells * model.dx)};
    if (!lift) return left;
    Lanes<T> unused;
    load_quads(lift, left.s.x, left.s.y, left.s.z, unused);
    left.s = left.s * select(has_velocity(mass), inverse_mass(mass), Lanes<T>{});
    return left;
  }
  void store_lift(T* lift, const Vec3<Lanes<T>>& change) const {
    if (lift) store_quads(lift, change.x, change.y, change.z, Lanes<T>{});
  }

  // From a block's first node to a batch of its nodes [m].
  Vec3<Lanes<T>> ways(int first) const {
    Vec3<Lanes<T>> x;
    for (int l = 0; l < width<Lanes<T>>; ++l) {
      const Vec3<T> p = way_to_node(model, first + l);
      x.x[l] = p.x, x.y[l] = p.y, x.z[l] = p.z;
    }
    return x;
  }

  // Solids have changed the velocities of a batch of nodes from v to `after`.
  void store_nodes(T* node, T* change, const Vec3<Lanes<T>>& v, const Vec3<Lanes<T>>& after,
                   Lanes<T> mass) const {
    using R = Lanes<T>;
    store_quads(node, after.x, after.y, after.z, mass);
    if (!has_change) return;
    Vec3<R> dv;
    R unused;
    load_quads(change, dv.x, dv.y, dv.z, unused);
    dv = dv + (after - v);
    store_quads(change, dv.x, dv.y, dv.z, unused);
  }

  // All of a block but its contacts with bodies; the solids near it, if there are bodies among them.
  std::vector<NearSolid<T>> block(Grid<T>& grid, std::int32_t b) const {
    T* node = grid.node(b);
    T* change = change_of(grid, b);
    for (int r = 0; r < 16; ++r) row(node + 16 * r, change + 16 * r);
    if (!model.solids.empty()) {
      ExchangeSum& exchange = grid.node_exchange[static_cast<std::size_t>(b)];
      exchange.clear();
      auto near = solids_near_block(model, balls, coord(grid, b));
      for (const Solid<T>& solid : near) {
        if (solid.body >= 0) return near;
      }
      const auto to_water = grid.has_water ? smooth(near) : std::vector<NearSolid<T>>{};
      for (int n = 0; n < 64 && !near.empty(); n += lane_count<T>)
        collide_nodes({near, to_water}, n, node + 4 * n, change + 4 * n, lift_at(grid, b, n),
                      grid.has_water ? grid.node_lift(b) + 4 * n : nullptr, exchange);
      if (near.empty()) no_lift(grid, b);
    }
    bound_velocities(grid, b);
    return {};
  }

  // Collect the contacts of a block's nodes with the solids near it.
  void find_contacts(Grid<T>& grid, const std::vector<NearSolid<T>>& near, BlockContacts<T>& out) const {
    for (int n = 0; n < 64; n += lane_count<T>) {
      Vec3<Lanes<T>> v;
      Lanes<T> mass;
      load_quads(grid.node(out.block) + 4 * n, v.x, v.y, v.z, mass);
      const Lift<Lanes<T>> lift = load_lift(lift_at(grid, out.block, n), mass);
      out.add(near, model.solids, ways(n), v, lift, mass, n, skin());
    }
    no_lift(grid, out.block);
  }

  // Apply them, once it is known how the bodies move.
  void apply(Grid<T>& grid, const BlockContacts<T>& all, const std::vector<Twist>& U) const {
    using R = Lanes<T>;
    T* node = grid.node(all.block);
    T* change = change_of(grid, all.block);
    ExchangeSum& exchange = grid.node_exchange[static_cast<std::size_t>(all.block)];
    for (const auto& nodes : all.nodes) {
      const Moved<R> now = apply_contacts(
          all, nodes, U,
          [&](const auto& contact, const auto& before, const auto&, const auto& v_co, const auto& after) {
            record(exchange.of(contact.solid->index), contact.inside, nodes.m, contact.arm, v_co, before,
                   after);
          });
      store_nodes(node + 4 * nodes.first, change + 4 * nodes.first, nodes.v, now.v, nodes.m);
      store_lift(lift_at(grid, all.block, nodes.first), now.lift - nodes.lift.s);
    }
    bound_velocities(grid, all.block);
  }

  // What the particles around a block will see of its velocities.
  void bound_velocities(Grid<T>& grid, std::int32_t b) const {
    grid.bounds[static_cast<std::size_t>(b)] =
        bounds_of(grid.node(b), change_of(grid, b), grid.lightest * T(1e-3));
  }

 private:
  static BlockCoord coord(const Grid<T>& grid, std::int32_t b) {
    return grid.blocks[static_cast<std::size_t>(b)];
  }
  T* change_of(Grid<T>& grid, std::int32_t b) const {
    return has_change ? grid.node_change(b) : grid.node(b);
  }
  static T* lift_at(Grid<T>& grid, std::int32_t b, int node) {
    return grid.has_lift ? grid.node_lift(b) + 4 * node : nullptr;
  }
  static void no_lift(Grid<T>& grid, std::int32_t b) {
    if (grid.has_lift) std::memset(grid.node_lift(b), 0, block_values * sizeof(T));
  }
  T skin() const { return T(skin_cells * model.dx); }

  // Bounds over the nodes of at least mass `least`, and over all of them whether they are finite.
  BlockBounds<T> bounds_of(const T* node, const T* change, T least) const {
    const Row<T> far = splat<Row<T>>(std::numeric_limits<T>::max());
    Row<T> least_v = far, most_v = -far, most{}, odd{};
    for (int r = 0; r < 16; ++r) {
      const Row<T> v = load_row<T>(node + 16 * r);
      const auto heavy = last_of_quads<T>(v) >= least;
      least_v = min(least_v, select(heavy, v, far));
      most_v = max(most_v, select(heavy, v, -far));
      odd += v - v;
      if (has_change) most = max(most, select(heavy, abs(load_row<T>(change + 16 * r)), Row<T>{}));
    }
    const Row<T> low = -max_of_nodes<T>(-least_v), high = max_of_nodes<T>(most_v);
    most = max_of_nodes<T>(most);
    const BlockBounds<T> out{{low[0], low[1], low[2]},
                             {high[0], high[1], high[2]},
                             std::max(most[0], std::max(most[1], most[2])),
                             !any(odd != Row<T>{})};
    return out;
  }

  static auto is_mass() {
    static constexpr T last[16] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    return load_row<T>(last) > T(0);
  }
  static Row<T> mass_only(Row<T> m) { return select(is_mass(), m, Row<T>{}); }
};

}  // namespace neve::detail
