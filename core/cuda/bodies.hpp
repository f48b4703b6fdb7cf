// Bodies that the snow moves: their velocities at the end of the step are found with those of the snow that touches them
// (coupling/body_solver.hpp). The host asks, for some velocities of the bodies, what the snow would do to them.
//
// Only blocks of nodes near a body take part. The nodes there keep their velocities before contact until the bodies' are
// known; contacts are found anew each time, which costs less than to keep them.
#pragma once

#include "cuda/node.hpp"

namespace neve::cuda {

// How many numbers a BodyResponse has; of so many bodies near a block these are summed in shared memory.
inline constexpr int response_numbers = 42, summed_bodies = 2;
static_assert(sizeof(BodyResponse) == response_numbers * sizeof(double));

// Whether a body is among the solids near a block: the same for all threads.
template <class T>
inline bool has_body(const NearSolids<T>& solids) {
  for (const Solid<T>& solid : solids) {
    if (solid.body >= 0) return true;
  }
  return false;
}

// Put the block on the list of those that wait. One thread does.
template <class T>
inline void wait_for_bodies(const Step<T>& s) {
  s.bodies.waiting[atomicAdd(&s.results->waiting, 1u)] = int(blockIdx.x);
}

// The responses of one block's nodes to the first few bodies that they meet; the others' go to memory at once.
template <class N>
struct BlockResponse {
  N sum[summed_bodies][response_numbers];
  int body[summed_bodies];  // -1: none

  void clear() {
    for (unsigned k = threadIdx.x; k < summed_bodies * response_numbers; k += blockDim.x)
      sum[k / response_numbers][k % response_numbers].clear();
    if (threadIdx.x < summed_bodies) body[threadIdx.x] = -1;
  }
  // The sums of a body: shared ones, or those in memory.
  N* of(int which, N* all) {
    for (int k = 0; k < summed_bodies; ++k) {
      const int before = atomicCAS(&body[k], -1, which);
      if (before == -1 || before == which) return sum[k];
    }
    return all + which * response_numbers;
  }
  void publish(N* all) const {
    for (unsigned k = threadIdx.x; k < summed_bodies * response_numbers; k += blockDim.x) {
      const int slot = int(k) / response_numbers, number = int(k) % response_numbers;
      if (body[slot] >= 0) all[body[slot] * response_numbers + number].add(sum[slot][number]);
    }
  }
};

// Let the solids near its block act on a node of mass m whose velocity before contact is v, if the bodies move with s.bodies.velocity;
// visit(solid, normal, arm, play, v_co, v before, v after) for each contact.
template <class C, class T, class F>
inline void meet_all(const Node<C>& node, const NearSolids<T>& solids, T m, Vec3<T>& v, Lift<T>& lift,
                     F&& visit) {
  const Step<T>& s = node.s;
  const Vec3<T> v_free = v, x = node.x();
  const T skin = node.step.skin;
  each_holding(solids, x, m, skin, [&](const Solid<T>& solid, const Vec3<T>& normal, bool inside) {
    const Facing<T> there = facing_before(solid, x, normal, v_free, lift.dt);
    const Vec3<T> arm = x - solid.centre, before = v;
    const Vec3<T> v_co = surface_velocity(solid, s.bodies.velocity, arm, normal);
    const Play<T> play = lift.play(normal);
    v = meet(solid, inside, there, v_co, v, lift);
    visit(solid, normal, arm, play, v_co, before, v);
  });
}

// What the snow of the waiting blocks does to each body: a block of threads per block of nodes.
template <class C>
inline void body_response(const Step<typename C::T>& s) {
  using T = typename C::T;
  using N = typename C::Number;
  if constexpr (C::has_solids) {
    __shared__ Marks marks;
    __shared__ BlockResponse<N> shared;
    const Node<C> node{s, std::size_t(s.bodies.waiting[blockIdx.x])};
    shared.clear();
    const NearSolids<T> solids = node.near(marks);
    const T m = node.m();
    Vec3<T> v = node.v();
    Lift<T> lift = node.lift(m);
    N* all = static_cast<N*>(s.bodies.response);
    meet_all(node, solids, m, v, lift,
             [&](const Solid<T>& solid, const Vec3<T>& normal, const Vec3<T>& arm, const Play<T>& play,
                 const Vec3<T>& v_co, const Vec3<T>& before, const Vec3<T>& after) {
               if (solid.body < 0) return;
               BodyResponse one;
               add_response(one, solid, true, m, normal, arm, play, v_co, before, after);
               N* to = shared.of(solid.body, all);
               for (int k = 0; k < 6; ++k) to[k].add(one.impulse[k]);
               for (int k = 0; k < 36; ++k) to[6 + k].add(one.slope[k]);
             });
    __syncthreads();
    shared.publish(all);
  }
}

// Give the nodes of the waiting blocks the velocities that they have when bodies move with s.bodies.velocity.
template <class C>
inline void meet_bodies(const Step<typename C::T>& s) {
  using T = typename C::T;
  using N = typename C::Number;
  if constexpr (C::has_solids) {
    __shared__ Marks marks;
    __shared__ BlockExchange<N> exchange;
    const Node<C> node{s, std::size_t(s.bodies.waiting[blockIdx.x])};
    exchange.clear();
    const NearSolids<T> solids = node.near(marks);
    const T m = node.m();
    const Vec3<T> v_free = node.v();
    Vec3<T> v = v_free;
    Lift<T> lift = node.lift(m);
    const Vec3<T> lift_before = lift.s;
    const Recorder<T, N> recorder{exchange, exchanged_of<C>(s), m, true};
    meet_all(node, solids, m, v, lift,
             [&](const Solid<T>& solid, const Vec3<T>&, const Vec3<T>& arm, const Play<T>&,
                 const Vec3<T>& v_co, const Vec3<T>& before,
                 const Vec3<T>& after) { recorder(solid, true, arm, v_co, before, after); });
    const Vec3<T> change = node.change() + (v - v_free);
    node.store(v, change, m);
    node.store_lift(lift.s - lift_before);
    node.bound(v, change, m);
    __syncthreads();
    exchange.publish(exchanged_of<C>(s), s.solid_count);
  }
}

}  // namespace neve::cuda
