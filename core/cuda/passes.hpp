// What is asked of all particles besides the step: their stress, and their volumes from the grid's density.
#pragma once

#include "cuda/g2p.hpp"

namespace neve::cuda {

inline constexpr int particle_threads = 128;

// Derive the stress from F_E and J_P, and report the rates that limit the time step: a thread per particle.
template <class C>
inline void refresh(const Step<typename C::T>& s) {
  using T = typename C::T;
  const unsigned p = blockIdx.x * blockDim.x + threadIdx.x;
  Seen<T> seen;
  if (p < s.particle_count) {
    const Particle<T> particle{s.particles, p};
    const Material<T, C::laws> material{s, p};
    const Mat3<T> F = particle.F_E(), G = particle.C();
    const Vec3<T> v = particle.v();
    const T J_P = particle.J_P();
    const Stress<T> now = material.stress(F, J_P);
    particle.store_tau(now.tau);
    const T sum = sum_of(particle.x()) + sum_of(v) + sum_of(F) + sum_of(G) + J_P;
    seen.extremes.add(true, v, now.modulus, particle.m(), particle.V0(), G, sum);
    seen.extremes.ice_room = material.ice_room(determinant(F) * J_P);
  }
  seen.template publish_from<particle_threads>(*s.results);
}

// Stomakhin et al. 2013, section 4.1, step 2: rho_p = sum_i m_i w_ip / dx^3, V0_p = m_p / rho_p. After p2g.
template <class C>
inline void measure_volumes(const Step<typename C::T>& s) {
  using T = typename C::T;
  using S = typename C::Spline;
  __shared__ Quad<T> tile[tile_nodes];
  const Home& home = s.nodes.homes[blockIdx.x];
  load_tile(tile, s.nodes.node, home);
  __syncthreads();
  const auto frame = TileFrame<T>::template of<S>(s.constants.step, home.at);
  const T dx = s.constants.step.cells.dx;
  for (unsigned i = threadIdx.x; i < home.count; i += blockDim.x) {
    const Particle<T> particle{s.particles, std::size_t(home.begin) + i};
    Stencil<T, S, GradientWeights> at;
    at.fill(frame, particle.x());
    T mass = T(0);
    for (int n = 0; n < S::nodes * S::nodes * S::nodes; ++n) {
      const int j = n / (S::nodes * S::nodes), k = n / S::nodes % S::nodes, l = n % S::nodes;
      mass += tile[at.first + node_after(j, k, l)].w * at.w[0][0][j] * at.w[1][0][k] * at.w[2][0][l];
    }
    s.particles.V0[particle.p] = particle.m() * (dx * dx * dx) / mass;
  }
}

}  // namespace neve::cuda
