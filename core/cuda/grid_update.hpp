// Grid: velocities, gravity, forces and collisions (Stomakhin et al. 2013, section 4.1, steps 4 to 6, explicit): a block of
// threads per block of nodes, a thread per node.
#pragma once

#include "cuda/bodies.hpp"

namespace neve::cuda {

// Momentum becomes velocity at the end of the step, force its change. Nodes without a velocity stay zero.
template <class C, class T>
NEVE_INLINE void accelerate(const Node<C>& node, Vec3<T>& v, Vec3<T>& change, T& m) {
  const Step<T>& s = node.s;
  const Quad<T> q = s.nodes.node[node.i];
  const T dt = node.step.dt, inverse_m = inverse_mass(q.w);
  m = q.w;
  if (!has_velocity(m)) {
    v = change = Vec3<T>{}, m = T(0);
    return;
  }
  change = s.constants.gravity * dt;
  if constexpr (C::has_force) {
    const Quad<T> f = s.nodes.change[node.i];
    change = {velocity_change(change.x, f.x, inverse_m, dt), velocity_change(change.y, f.y, inverse_m, dt),
              velocity_change(change.z, f.z, inverse_m, dt)};
  }
  v = {node_velocity(q.x, inverse_m, change.x), node_velocity(q.y, inverse_m, change.y),
       node_velocity(q.z, inverse_m, change.z)};
}

// The solids near the block act on the node; the change keeps what they did.
template <class C, class T>
NEVE_INLINE void collide_with(const Node<C>& node, const NearSolids<T>& solids, T m, Vec3<T>& v,
                              Vec3<T>& change, const Recorder<T, typename C::Number>& recorder) {
  const auto& step = node.step;
  const Vec3<T> before = v, x = node.x();
  if constexpr (C::has_play) {
    Lift<T> lift = node.lift(m);
    const Vec3<T> lift_before = lift.s;
    v = collide(solids, x, v, lift, step.skin, step.dt, m, recorder);
    node.store_lift(lift.s - lift_before);
  } else {
    NoLift none;
    v = collide(solids, x, v, none, step.skin, step.dt, m, recorder);
  }
  change = change + (v - before);
}

template <class C>
inline void grid_update(const Step<typename C::T>& s) {
  using T = typename C::T;
  using N = typename C::Number;
  if (halted(s)) return;
  const Node<C> node{s, blockIdx.x};
  Vec3<T> v, change;
  T m;
  accelerate(node, v, change, m);
  if constexpr (C::has_solids) {
    __shared__ Marks marks;
    __shared__ BlockExchange<N> exchange;
    exchange.clear();
    const NearSolids<T> solids = node.near(marks);
    if (s.bodies.count != 0 && has_body(solids)) {
      node.store(v, change, m);
      if (threadIdx.x == 0) wait_for_bodies(s);
      return;
    }
    if (!solids.empty()) {
      collide_with(node, solids, m, v, change,
                   Recorder<T, N>{exchange, exchanged_of<C>(s), m, node.counts()});
      __syncthreads();
      exchange.publish(exchanged_of<C>(s), s.solid_count);
    } else {
      node.store_lift({});
    }
  }
  node.store(v, change, m);
  node.bound(v, change, m);
}

// The differences of velocity that a home's particles can see: a thread per home.
inline constexpr int report_threads = 128;
template <class C>
inline void report_nodes(const Step<typename C::T>& s) {
  using T = typename C::T;
  if (halted(s)) return;
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
