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

// A block of nodes that waits, and what its threads' nodes bring: all threads of the block must come to make one.
template <class C>
struct Waiting {
  using T = typename C::T;
  const Node<C> node;
  const NearSolids<T> solids;  // after a barrier
  const T m;
  const Vec3<T> v_free;  // before contact
  Vec3<T> v;
  Lift<T> lift;

  Waiting(const Step<T>& s, Marks& marks)
      : node{s, std::size_t(s.bodies.waiting[blockIdx.x])},
        solids(node.near(marks)),
        m(node.m()),
        v_free(node.v()),
        v(v_free),
        lift(node.lift(m)) {}

  // Let the solids near the block act on the node, if the bodies move with s.bodies.velocity;
  // visit(solid, normal, arm, play, v_co, v before, v after) for each contact.
  template <class F>
  void meet_all(F&& visit) {
    const Vec3<T> x = node.x();
    each_holding(solids, x, m, node.step.skin,
                 [&](const Solid<T>& solid, const Vec3<T>& normal, bool inside) {
                   const Facing<T> there = facing_before(solid, x, normal, v_free, lift.dt, inside);
                   const Vec3<T> arm = x - solid.centre, before = v;
                   const Vec3<T> v_co = surface_velocity(solid, node.s.bodies.velocity, arm, normal);
                   const Play<T> play = lift.play(normal);
                   v = meet(solid, inside, there, v_co, v, lift);
                   visit(solid, normal, arm, play, v_co, before, v);
                 });
  }
};

// What the snow of the waiting blocks does to each body: a block of threads per block of nodes.
template <class C>
inline void body_response(const Step<typename C::T>& s) {
  using T = typename C::T;
  using N = typename C::Number;
  if constexpr (C::has_solids) {
    __shared__ Marks marks;
    __shared__ BlockResponse<N> shared;
    shared.clear();
    Waiting<C> here{s, marks};
    if (!here.node.counts()) return;
    N* all = static_cast<N*>(s.bodies.response);
    here.meet_all([&](const Solid<T>& solid, const Vec3<T>& normal, const Vec3<T>& arm, const Play<T>& play,
                      const Vec3<T>& v_co, const Vec3<T>& before, const Vec3<T>& after) {
      if (solid.body < 0) return;
      BodyResponse one;
      add_response(one, solid, true, here.m, normal, arm, play, v_co, before, after);
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
    exchange.clear();
    Waiting<C> here{s, marks};
    const Vec3<T> lift_before = here.lift.s;
    const Recorder<T, N> recorder{exchange, exchanged_of<C>(s), here.m, here.node.counts()};
    here.meet_all([&](const Solid<T>& solid, const Vec3<T>&, const Vec3<T>& arm, const Play<T>&,
                      const Vec3<T>& v_co, const Vec3<T>& before,
                      const Vec3<T>& after) { recorder(solid, true, arm, v_co, before, after); });
    const Vec3<T> change = here.node.change() + (here.v - here.v_free);
    here.node.store(here.v, change, here.m);
    here.node.store_lift(here.lift.s - lift_before);
    here.node.bound(here.v, change, here.m);
    __syncthreads();
    exchange.publish(exchanged_of<C>(s), s.solid_count);
  }
}

}  // namespace neve::cuda
