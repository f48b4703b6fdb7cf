// Grid to particles and particles to the grid of the next step at once (Wang et al. 2020, G2P2G): what a particle has just
// become need not be read again. A variant, to be measured; cuda/g2p.hpp and cuda/p2g.hpp do the same one after the other.
//
// The next dt is not known yet, so the force comes to the nodes apart from the momentum. If a particle has left its home, or
// the step is the last, what was scattered is for nothing: the host sorts, and p2g scatters anew.
#pragma once

#include "cuda/g2p.hpp"
#include "cuda/p2g.hpp"

namespace neve::cuda {

inline constexpr int fused_slots =
    4;  // particles that a warp shows at a time: three tiles leave room for so many

template <class C>
inline void g2p2g(const Step<typename C::T>& s) {
  if constexpr (C::is_fused) {
    using T = typename C::T;
    using X = typename C::Transfer;
    using S = typename C::Spline;
    using Given = Shown<T, S, typename X::ScatterWeights, 0, X::modes>;
    using Force = Shown<T, S, typename X::ScatterWeights, 1, 3>;
    __shared__ Quad<T> tile[tile_nodes], out[tile_nodes], force_out[tile_nodes];
    __shared__ Given given[fused_slots * gather_threads / warp];
    __shared__ Force forces[fused_slots * gather_threads / warp];
    __shared__ Marks marks;
    __shared__ BlockExchange<typename C::Number> exchange;
    const Home& home = s.nodes.homes[blockIdx.x];
    load_tile(tile, s.nodes.node, home);
    clear_tile(out);
    clear_tile(force_out);
    if constexpr (C::has_solids) {
      exchange.clear();
      mark_near(s, home.at, T(3.5), T(7.1), marks);
    }
    __syncthreads();
    const auto& step = s.constants.step;
    const auto frame = TileFrame<T>::template of<S>(step, home.at);
    const HomeGather<C> from{s, step, frame, tile, tile};
    const unsigned lane = threadIdx.x % warp, first_slot = threadIdx.x / warp * fused_slots;
    Seen<T> seen;
    each_warp(home, [&](std::size_t p, int count) {
      Given mine{};
      Mat3<T> A;
      if (lane < unsigned(count)) {
        Advanced<T> now;
        if constexpr (C::has_solids) {
          now = from.advance_one(p, NearSolids<T>{s.solids, s.solid_count, marks}, exchange, seen);
        } else {
          now = from.advance_one(p, NoSolids<T>{}, exchange, seen);
        }
        const Particle<T> particle{s.particles, p};
        const T m = particle.m(), V0 = particle.V0();
        const Sym3<T>& tau = now.material.stress.tau;
        mine.at.fill(frame, now.x);
        show<C>(now.v, m, now.C, tau, V0, step, mine);
        A = force_of<C>(tau, m, V0, step);
      }
      scatter<fused_slots, Given, NodeSums<T, S, typename X::ScatterWeights, 0, X::modes>>(
          mine, count, given + first_slot, out);
      const Force force{mine.at, {A.c0, A.c1, A.c2}, T(0)};
      scatter<fused_slots, Force, NodeSums<T, S, typename X::ScatterWeights, 1, 3>>(
          force, count, forces + first_slot, force_out);
    });
    seen.template publish_from<gather_threads>(*s.results);
    __syncthreads();
    add_tile(out, s.nodes.next, home);
    add_tile(force_out, s.nodes.next_force, home);
    if constexpr (C::has_solids) exchange.publish(exchanged_of<C>(s), s.solid_count);
  }
}

}  // namespace neve::cuda
