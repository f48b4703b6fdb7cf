// Grid: velocities, gravity, forces, and collisions (Stomakhin et al. 2013, section 4.1, steps 4 to 6, explicit).
#pragma once

#include <limits>

#include "coupling/body_solver.hpp"
#include "mpm/model.hpp"
#include "mpm/report.hpp"
#include "mpm/stencil.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

// The solids whose surface may lie within `reach` of the point.
template <class T>
std::vector<Solid<T>> solids_near(const std::vector<Solid<T>>& solids, const Vec3<T>& x, T reach) {
  std::vector<Solid<T>> near;
  for (const Solid<T>& solid : solids) {
    if (is_near(solid, x, reach)) near.push_back(solid);
  }
  return near;
}

template <class T>
Vec3<T> node_position(const Model<T>& model, BlockCoord at, int i, int j, int k) {
  const auto dx = static_cast<T>(model.dx);
  return {T(4 * at.x + i) * dx, T(4 * at.y + j) * dx, T(4 * at.z + k) * dx};
}

template <class T>
struct BlockUpdate {
  const Model<T>& model;
  T dt;
  bool has_change;
  Row<T> gravity_step;  // dt g, 0

  BlockUpdate(const Model<T>& m, double step, bool change) : model(m), dt(T(step)), has_change(change) {
    const T quad[4] = {m.gravity.x * dt, m.gravity.y * dt, m.gravity.z * dt, T(0)};
    gravity_step = row_of_quad(quad);
  }

  // One row of four nodes: v_n = (m v) / m, v = v_n + dt f / m + dt g. Nodes without mass stay zero; so do those whose
  // mass is denormal (their weight is below 1e-30), since 1 / m would overflow.
  void row(T* node, T* change) const {
    const Row<T> a = load_row<T>(node);
    const Row<T> m = last_of_quads<T>(a);
    const auto full = m >= std::numeric_limits<T>::min() * T(4);
    const Row<T> inv = T(1) / select(full, m, splat<Row<T>>(1));
    const Row<T> mass = mass_only(m);
    Row<T> step = gravity_step;
    if (has_change) {
      step += load_row<T>(change) * inv * dt;
      store_row<T>(change, select(full, step, Row<T>{}));
    }
    store_row<T>(node, select(full, select(is_mass(), mass, a * inv + step), Row<T>{}));
  }

  // Let the near solids act on a batch of nodes from the block's `first`; the change keeps what they did.
  void collide_nodes(const std::vector<Solid<T>>& solids, BlockCoord at, int first, T* node, T* change,
                     ExchangeSum& exchange) const {
    Vec3<Lanes<T>> v;
    Lanes<T> mass;
    load_quads(node, v.x, v.y, v.z, mass);
    const Vec3<Lanes<T>> after =
        collide(solids, positions(at, first), v, skin(), mass,
                [&](const auto& solid, const auto& inside, const auto&... exchanged) {
                  record(exchange.of(solid.index), inside, mass, exchanged...);
                });
    store_nodes(node, change, v, after, mass);
  }

  Vec3<Lanes<T>> positions(BlockCoord at, int first) const {
    Vec3<Lanes<T>> x;
    for (int l = 0; l < width<Lanes<T>>; ++l) {
      const int n = first + l;
      const Vec3<T> p = node_position(model, at, n / 16, n / 4 % 4, n % 4);
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

  // All of a block but its contacts with bodies; whether it may have some.
  bool block(Grid<T>& grid, std::int32_t b) const {
    T* node = grid.node(b);
    T* change = change_of(grid, b);
    for (int r = 0; r < 16; ++r) row(node + 16 * r, change + 16 * r);
    if (!model.solids.empty()) {
      ExchangeSum& exchange = grid.node_exchange[static_cast<std::size_t>(b)];
      exchange.clear();
      const auto near = solids_near_block(grid, b);
      for (const Solid<T>& solid : near) {
        if (solid.body >= 0) return true;
      }
      for (int n = 0; n < 64 && !near.empty(); n += lane_count<T>)
        collide_nodes(near, coord(grid, b), n, node + 4 * n, change + 4 * n, exchange);
    }
    bound_velocities(grid, b);
    return false;
  }

  // Collect the contacts of a block's nodes with solids.
  void find_contacts(Grid<T>& grid, BlockContacts<T>& out) const {
    const auto near = solids_near_block(grid, out.block);
    for (int n = 0; n < 64; n += lane_count<T>) {
      Vec3<Lanes<T>> v;
      Lanes<T> mass;
      load_quads(grid.node(out.block) + 4 * n, v.x, v.y, v.z, mass);
      out.add(near, model.solids, positions(coord(grid, out.block), n), v, mass, n, skin());
    }
  }

  // Apply them, once it is known how the bodies move.
  void apply(Grid<T>& grid, const BlockContacts<T>& all, const std::vector<Twist>& U) const {
    using R = Lanes<T>;
    T* node = grid.node(all.block);
    T* change = change_of(grid, all.block);
    ExchangeSum& exchange = grid.node_exchange[static_cast<std::size_t>(all.block)];
    for (const auto& nodes : all.nodes) {
      const Vec3<R> v = apply_contacts(
          all, nodes, U, [&](const auto& contact, const auto& before, const auto& v_co, const auto& after) {
            record(exchange.of(contact.solid->index), contact.inside, nodes.m, contact.arm, v_co, before,
                   after);
          });
      store_nodes(node + 4 * nodes.first, change + 4 * nodes.first, nodes.v, v, nodes.m);
    }
    bound_velocities(grid, all.block);
  }

 private:
  static BlockCoord coord(const Grid<T>& grid, std::int32_t b) {
    return grid.blocks[static_cast<std::size_t>(b)];
  }
  T* change_of(Grid<T>& grid, std::int32_t b) const {
    return has_change ? grid.node_change(b) : grid.node(b);
  }
  T skin() const { return T(skin_cells * model.dx); }

  std::vector<Solid<T>> solids_near_block(const Grid<T>& grid, std::int32_t b) const {
    const auto dx = static_cast<T>(model.dx);
    const Vec3<T> corner = node_position(model, coord(grid, b), 0, 0, 0),
                  half{T(1.5) * dx, T(1.5) * dx, T(1.5) * dx};
    return solids_near(model.solids, corner + half,
                       T(3.2) * dx);  // half a block's diagonal, and the widest margin
  }

  void bound_velocities(Grid<T>& grid, std::int32_t b) const {
    grid.bounds[static_cast<std::size_t>(b)] =
        bounds_of(grid.node(b), change_of(grid, b), grid.lightest * T(1e-3));
  }

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
  const std::vector<Twist> U = BodyVelocitySolver(model.bodies, dt).solve(grid.contacts, count);
  each_index(count, [&](std::size_t k) { update.apply(grid, grid.contacts[k], U); });
  for (std::size_t i = 0; i < U.size(); ++i) {
    Solid<T>& solid = model.solids[static_cast<std::size_t>(model.bodies.solids[i])];
    solid.velocity = linear<T>(U[i]);
    solid.omega = angular<T>(U[i]);
  }
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
  return merge_each<GridReport>(grid.homes.size(),
                                [&](std::size_t h) { return detail::grid_report_of(grid, grid.homes[h]); });
}

}  // namespace neve
