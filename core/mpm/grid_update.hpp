// Grid: velocities, gravity, forces, and collisions (Stomakhin et al. 2013, section 4.1, steps 4 to 6, explicit).
#pragma once

#include "mpm/model.hpp"
#include "mpm/stencil.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

// The solids whose surface may lie within `reach` of the point.
template <class T>
std::vector<Solid<T>> solids_near(const std::vector<Solid<T>>& solids, const Vec3<T>& x, T reach) {
  std::vector<Solid<T>> near;
  for (const Solid<T>& solid : solids) {
    if (surface(solid, x).phi <= reach) near.push_back(solid);
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

  // One row of four nodes: v_n = (m v) / m, v = v_n + dt f / m + dt g. Nodes without mass stay zero.
  void row(T* node, T* change) const {
    const Row<T> a = load<Row<T>>(node);
    const Row<T> m = last_of_quads<T>(a);
    const auto full = m > T(0);
    const Row<T> inv = T(1) / select(full, m, splat<Row<T>>(1));
    const Row<T> mass = mass_only(m);
    Row<T> step = gravity_step;
    if (has_change) {
      step += load<Row<T>>(change) * inv * dt;
      store(change, select(full, step, Row<T>{}));
    }
    store(node, select(full, select(is_mass(), mass, a * inv + step), Row<T>{}));
  }

  // Let the near solids act on the four nodes; the change keeps what they did.
  void collide_row(const std::vector<Solid<T>>& solids, BlockCoord at, int i, int j, T* node, T* change) const {
    for (int k = 0; k < 4; ++k, node += 4, change += 4) {
      if (!(node[3] > T(0))) continue;
      const Vec3<T> v{node[0], node[1], node[2]};
      const Vec3<T> after = collide(solids, node_position(model, at, i, j, k), v);
      for (int c = 0; c < 3; ++c) {
        if (has_change) change[c] += after[c] - v[c];
        node[c] = after[c];
      }
    }
  }

  void block(Grid<T>& grid, std::int32_t b) const {
    const BlockCoord at = grid.blocks[static_cast<std::size_t>(b)];
    T* node = grid.node(b);
    T* change = has_change ? grid.node_change(b) : node;
    for (int r = 0; r < 16; ++r) row(node + 16 * r, change + 16 * r);
    if (model.solids.empty()) return;
    const auto dx = static_cast<T>(model.dx);
    const Vec3<T> corner = node_position(model, at, 0, 0, 0), half{T(1.5) * dx, T(1.5) * dx, T(1.5) * dx};
    const auto near = solids_near(model.solids, corner + half, T(2.7) * dx);
    if (near.empty()) return;
    for (int r = 0; r < 16; ++r) collide_row(near, at, r / 4, r % 4, node + 16 * r, change + 16 * r);
  }

 private:
  static auto is_mass() {
    Row<T> mark{};
    for (int k = 3; k < 16; k += 4) mark[k] = T(1);
    return mark > T(0);
  }
  static Row<T> mass_only(Row<T> m) { return select(is_mass(), m, Row<T>{}); }
};

}  // namespace detail

// Turn momenta into velocities at the end of the step.
template <class T>
void grid_update(const Model<T>& model, Grid<T>& grid, double dt) {
  const detail::BlockUpdate<T> update(model, dt, grid.has_change);
  const auto blocks = static_cast<std::int64_t>(grid.blocks.size());
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 8)
#endif
  for (std::int64_t b = 0; b < blocks; ++b) update.block(grid, static_cast<std::int32_t>(b));
}

}  // namespace neve
