// Grid: velocities, gravity, forces and collisions (Stomakhin et al. 2013, section 4.1, steps 4 to 6, explicit): a block of
// threads per block of nodes, a thread per node.
#pragma once

#include "cuda/choices.hpp"
#include "cuda/grid/reduce.hpp"
#include "cuda/solids.hpp"
#include "mpm/node_update.hpp"

namespace neve::cuda {

template <class C>
struct NodeUpdate {
  using T = typename C::T;
  const Step<T>& s;
  std::size_t i;

  // Momentum becomes velocity at the end of the step, force its change. Nodes without a velocity stay zero.
  NEVE_INLINE void accelerate(Vec3<T>& v, Vec3<T>& change, T& m) const {
    const Quad<T> q = s.nodes.node[i];
    const T dt = s.constants.step.dt, inverse_m = inverse_mass(q.w);
    m = q.w;
    if (!has_velocity(m)) {
      v = change = Vec3<T>{}, m = T(0);
      return;
    }
    change = s.constants.gravity * dt;
    if constexpr (C::has_change) {
      const Quad<T> f = s.nodes.change[i];
      change = {velocity_change(change.x, f.x, inverse_m, dt), velocity_change(change.y, f.y, inverse_m, dt),
                velocity_change(change.z, f.z, inverse_m, dt)};
    }
    v = {node_velocity(q.x, inverse_m, change.x), node_velocity(q.y, inverse_m, change.y),
         node_velocity(q.z, inverse_m, change.z)};
  }

  // The solids near the block act on the node; the change keeps what they did.
  NEVE_INLINE void collide_with(const NearSolids<T>& solids, const Vec3<T>& x, T m, Vec3<T>& v,
                                Vec3<T>& change, const Recorder<T>& recorder) const {
    const auto& step = s.constants.step;
    const Vec3<T> before = v;
    if constexpr (C::has_play) {
      const Quad<T> ms = s.nodes.lift[i];
      const T inverse_m = has_velocity(m) ? inverse_mass(m) : T(0);
      Lift<T> lift{Vec3<T>{ms.x, ms.y, ms.z} * inverse_m, step.dt, T(play_cells * double(step.cells.dx))};
      const Vec3<T> lift_before = lift.s;
      v = collide(solids, x, v, lift, step.skin, step.dt, m, recorder);
      const Vec3<T> gained = lift.s - lift_before;
      s.nodes.lift[i] = {gained.x, gained.y, gained.z, T(0)};
    } else {
      NoLift none;
      v = collide(solids, x, v, none, step.skin, step.dt, m, recorder);
    }
    change = change + (v - before);
  }

  NEVE_INLINE void store(const Vec3<T>& v, const Vec3<T>& change, T m) const {
    s.nodes.node[i] = {v.x, v.y, v.z, m};
    if constexpr (C::has_change) s.nodes.change[i] = {change.x, change.y, change.z, T(0)};
  }
};

// The bounds of a block of nodes; nodes lighter than a thousandth of the lightest particle are left out.
template <class C, class T>
NEVE_INLINE void bound(const Step<T>& s, const Vec3<T>& v, const Vec3<T>& change, T m) {
  constexpr T far = std::numeric_limits<T>::max();
  T most[8] = {-far, -far, -far, -far, -far, -far, T(0), T(0)};
  if (m >= s.lightest * T(1e-3)) {
    for (int k = 0; k < 3; ++k) most[k] = v[k], most[3 + k] = -v[k];
    if constexpr (C::has_change) most[6] = max(abs(change.x), max(abs(change.y), abs(change.z)));
  }
  const T odd = (v.x - v.x) + (v.y - v.y) + (v.z - v.z) + (m - m);
  most[7] = odd == T(0) ? T(0) : T(1);
  block_max<block_nodes>(most);
  if (threadIdx.x == 0) {
    s.nodes.bounds[blockIdx.x] = {
        {-most[3], -most[4], -most[5]}, {most[0], most[1], most[2]}, most[6], most[7] == T(0)};
  }
}

template <class C>
inline void grid_update(const Step<typename C::T>& s) {
  using T = typename C::T;
  const int n = int(threadIdx.x);
  const NodeUpdate<C> node{s, std::size_t(blockIdx.x) * block_nodes + threadIdx.x};
  Vec3<T> v, change;
  T m;
  node.accelerate(v, change, m);
  if constexpr (C::has_solids) {
    __shared__ Marks marks;
    __shared__ BlockExchange exchange;
    const BlockCoord at = s.nodes.at[blockIdx.x];
    clear_exchange(exchange);
    mark_near(s, at, T(1.5), T(3.2), marks);
    const NearSolids<T> solids{s.solids, s.solid_count, marks};
    if (!solids.empty()) {
      const T dx = s.constants.step.cells.dx;
      const Vec3<T> x{T(4 * at.x + n / 16) * dx, T(4 * at.y + n / 4 % 4) * dx, T(4 * at.z + n % 4) * dx};
      node.collide_with(solids, x, m, v, change, Recorder<T>{exchange, s.exchanged, m, true});
      __syncthreads();
      publish_exchange(exchange, s.exchanged, s.solid_count);
    } else if constexpr (C::has_play) {
      s.nodes.lift[node.i] = Quad<T>{};
    }
  }
  node.store(v, change, m);
  bound<C>(s, v, change, m);
}

// The differences of velocity that a home's particles can see: a thread per home.
inline constexpr int report_threads = 128;
template <class C>
inline void report_nodes(const Step<typename C::T>& s) {
  using T = typename C::T;
  const unsigned h = blockIdx.x * blockDim.x + threadIdx.x;
  double most[3] = {0, 0, 0};  // as the extremes from node_speed on
  if (h < s.home_count) {
    constexpr T far = std::numeric_limits<T>::max();
    Vec3<T> low{far, far, far}, high{-far, -far, -far};
    bool finite = true;
    for (int b : s.nodes.homes[h].nodes) {
      const Bounds<T>& bounds = s.nodes.bounds[b];
      for (int k = 0; k < 3; ++k) low[k] = min(low[k], bounds.low[k]), high[k] = max(high[k], bounds.high[k]);
      most[2] = max(most[2], double(bounds.change));
      finite = finite && bounds.finite != 0;
    }
    if (!finite) s.results->not_finite = 1;
    for (int k = 0; k < 3; ++k) {
      const double l = double(low[k]), u = double(high[k]);
      most[1] += (u - l) * (u - l), most[0] += max(l * l, u * u);
    }
  }
  block_max<report_threads>(most);
  if (threadIdx.x == 0) publish(*s.results, node_speed, most);
}

}  // namespace neve::cuda
