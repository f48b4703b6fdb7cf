// Particles to grid (Stomakhin et al. 2013, section 4.1, steps 1 and 3): a block of threads per home.
#pragma once

#include "cuda/grid/scatter.hpp"
#include "cuda/pace.hpp"
#include "cuda/particle.hpp"
#include "mpm/particle_update.hpp"

namespace neve::cuda {

inline constexpr int home_threads = 128;

// f(particle, how many of the warp's lanes have one) for each particle of a home, warp by warp; idle lanes get the
// particle of the first lane.
template <class F>
NEVE_INLINE void each_warp(const Home& home, F&& f) {
  const unsigned lane = threadIdx.x % warp;
  for (unsigned first = threadIdx.x - lane; first < home.count; first += blockDim.x) {
    const unsigned left = home.count - first, count = left < warp ? left : warp;
    f(std::size_t(home.begin) + first + (lane < count ? lane : 0), int(count));
  }
}

// The home that a block of threads is for.
template <class T>
inline const Home& home_of_launch(const Step<T>& s) {
  return s.nodes.homes[s.nodes.some == nullptr ? int(blockIdx.x) : s.nodes.some[blockIdx.x]];
}

// Whether a home may add to its nodes now. Of one colour, the parities of the block's coordinates, no two homes share
// nodes: if one colour follows another and a home has one warp, sums are made in an order that is always the same.
template <class T>
inline bool is_turn_of(const Step<T>& s, const Home& home) {
  const unsigned colour = unsigned(home.at.x & 1) * 4 + unsigned(home.at.y & 1) * 2 + unsigned(home.at.z & 1);
  return s.colour == all_colours || s.colour == colour;
}

// What a particle gives to momentum and mass, and to the force where that comes apart: then no dt need be known.
template <class C, class T, class Given>
NEVE_INLINE void show(const Vec3<T>& v, T m, const Mat3<T>& G, const Sym3<T>& tau, T V0,
                      const StepConstants<T>& step, Given& mine) {
  using X = typename C::Transfer;
  const Contribution<T> out = contribution<X>(v, m, G, C::is_fused ? Sym3<T>{} : tau, V0, step);
  mine.mode[0] = out.momentum, mine.mass = out.mass;
  if constexpr (X::has_matrix) mine.mode[1] = out.A.c0, mine.mode[2] = out.A.c1, mine.mode[3] = out.A.c2;
}
template <class C, class T>
NEVE_INLINE Mat3<T> force_of(const Sym3<T>& tau, T m, T V0, const StepConstants<T>& step) {
  using X = typename C::Transfer;
  if constexpr (C::has_change) {
    return X::force(tau, V0, step.cells);
  } else {
    return X::matrix(Mat3<T>{}, tau, m, V0, T(1), step.cells);
  }
}

template <class C>
inline void p2g(const Step<typename C::T>& s) {
  using T = typename C::T;
  using X = typename C::Transfer;
  using S = typename C::Spline;
  constexpr int modes = X::has_matrix ? X::modes : 1;
  using Given = Shown<T, S, typename X::ScatterWeights, 0, modes>;
  using Force = Shown<T, S, typename X::ScatterWeights, 1, 3>;
  constexpr std::size_t shown = sizeof(Given) + (C::has_force ? sizeof(Force) : 0);
  constexpr int slots = slots_for<T>(shown, 2);
  __shared__ Quad<T> tile[tile_nodes], force_tile[C::has_force ? tile_nodes : 1];
  __shared__ Given given[slots * home_threads / warp];
  __shared__ Force forces[C::has_force ? slots * home_threads / warp : 1];
  const Home& home = home_of_launch(s);
  if (halted(s) || !is_turn_of(s, home)) return;
  clear_tile(tile);
  if constexpr (C::has_force) clear_tile(force_tile);
  __syncthreads();
  const auto step = constants_of(s);
  const auto frame = TileFrame<T>::template of<S>(step, home.at);
  const unsigned first_slot = threadIdx.x / warp * slots;
  each_warp(home, [&](std::size_t p, int count) {
    const Particle<T> particle{s.particles, p};
    const T m = particle.m(), V0 = particle.V0();
    const Sym3<T> tau = particle.tau();
    Given mine;
    mine.at.fill(frame, particle.x());
    show<C>(particle.v(), m, particle.C(), tau, V0, step, mine);
    for (int n = 4; n < modes; ++n) mine.mode[n] = particle.mode(3 * (n - 4)) * m;
    scatter<slots, Given, NodeSums<T, S, typename X::ScatterWeights, 0, modes>>(mine, count,
                                                                                given + first_slot, tile);
    if constexpr (C::has_force) {
      const Mat3<T> A = force_of<C>(tau, m, V0, step);
      const Force force{mine.at, {A.c0, A.c1, A.c2}, T(0)};
      scatter<slots, Force, NodeSums<T, S, typename X::ScatterWeights, 1, 3>>(
          force, count, forces + first_slot, force_tile);
    }
  });
  __syncthreads();
  add_tile(tile, s.nodes.node, home);
  if constexpr (C::has_force) add_tile(force_tile, s.nodes.change, home);
}

// (m s)_i = sum_p w_ip m_p s_p, s how far the particle has left surfaces with play: the last of its modes.
template <class C>
inline void scatter_lift(const Step<typename C::T>& s) {
  using T = typename C::T;
  using S = typename C::Spline;
  using Given = Shown<T, S, GradientWeights, 0, 1>;
  constexpr int first = 3 * (C::Transfer::modes - 4), slots = slots_for<T>(sizeof(Given), 2);
  __shared__ Quad<T> tile[tile_nodes];
  __shared__ Given given[slots * home_threads / warp];
  const Home& home = home_of_launch(s);
  if (halted(s) || !is_turn_of(s, home)) return;
  clear_tile(tile);
  __syncthreads();
  const auto frame = TileFrame<T>::template of<S>(s.constants.step, home.at);
  each_warp(home, [&](std::size_t p, int count) {
    const Particle<T> particle{s.particles, p};
    Given mine;
    mine.at.fill(frame, particle.x());
    mine.mode[0] = particle.mode(first) * particle.m(), mine.mass = T(0);
    scatter<slots, Given, NodeSums<T, S, GradientWeights, 0, 1>>(mine, count,
                                                                 given + threadIdx.x / warp * slots, tile);
  });
  __syncthreads();
  add_tile(tile, s.nodes.lift, home);
}

}  // namespace neve::cuda
