// Grid to particles (Stomakhin et al. 2013, section 4.1, steps 7 to 10) and the stress for the next step: a block of threads
// per home, a thread per particle.
#pragma once

#include "cuda/grid/gather.hpp"
#include "cuda/grid/reduce.hpp"
#include "cuda/pace.hpp"
#include "cuda/particle.hpp"
#include "cuda/solids.hpp"
#include "mpm/particle_report.hpp"

namespace neve::cuda {

inline constexpr int gather_threads = 128;

// What a thread has seen of its particles.
template <class T>
struct Seen {
  Extremes<T> extremes;
  bool drifted = false;
  unsigned offender = 0;

  template <int Threads>
  NEVE_INLINE void publish_from(Results& results) {
    const Extremes<T>& e = extremes;
    T most[] = {e.wave,        e.speed,         e.fastest,           e.rate2,
                e.compression, e.displacement2, -e.min_volume_ratio, -e.ice_room};
    if (!e.finite) results.not_finite = 1;  // whoever writes, writes the same
    if (drifted) results.drifted = 1;
    if (offender != 0) atomicMax(&results.offender, offender);
    block_max<Threads>(most);
    if (threadIdx.x == 0) publish(results, wave, most);
  }
};

template <class C>
struct HomeGather {
  using T = typename C::T;
  using X = typename C::Transfer;
  using S = typename C::Spline;
  const Step<T>& s;
  const StepConstants<T>& step;
  const TileFrame<T>& frame;
  const Quad<T>*tile, *change;

  template <class Solids>
  NEVE_INLINE Advanced<T> advance_one(std::size_t p, const Solids& solids,
                                      BlockExchange<typename C::Number>& exchange, Seen<T>& seen) const {
    const Particle<T> particle{s.particles, p};
    const Vec3<T> x = particle.x();
    const T m = particle.m();
    Stencil<T, S, typename X::GatherWeights> at;
    at.fill(frame, x);
    Vec3<T> sum[X::modes];
    gather(tile, at, sum);
    Gathered<T> grid{sum[0], {sum[1], sum[2], sum[3]}};
    gather_change(at, grid);
    const Material<T, C::laws> material{s, p};
    Advanced<T> now;
    now.grad_v = X::velocity_gradient(grid.G, step.cells);
    move<X>(now, particle, grid, step, solids,
            Recorder<T, typename C::Number>{exchange, exchanged_of<C>(s), m, s.commit != 0});
    deform(now, particle, step, material);
    const T J = determinant(now.material.F_E) * now.material.J_P, room = material.ice_room(J);
    if (near_ice(room)) material.add_ice(J, step.cells.dx / step.dt, now.material.stress);
    seen.extremes.ice_room = min(room, seen.extremes.ice_room);
    if (seen.extremes.add_step(true, now, m, particle.V0(), step) > T(0))
      seen.offender = max(seen.offender, ~s.particles.id[p]);
    for (int a = 0; a < 3; ++a) {
      const T u = frame.local(now.x[a], a);
      seen.drifted = seen.drifted || u < T(0) || u >= T(S::reach);
    }
    if (s.commit != 0) keep(particle, now, sum, x);
    return now;
  }

 private:
  template <class Weights>
  NEVE_INLINE void gather_change(const Stencil<T, S, Weights>& at, Gathered<T>& grid) const {
    if constexpr (X::has_affine_change) {
      Vec3<T> sum[4];
      gather(change, at, sum);
      grid.change = sum[0], grid.G_change = {sum[1], sum[2], sum[3]};
    } else if constexpr (X::has_change) {
      Vec3<T> sum[1];
      gather(change, at, sum);
      grid.change = sum[0];
    }
  }

  NEVE_INLINE void keep(const Particle<T>& particle, const Advanced<T>& now, const Vec3<T> (&sum)[X::modes],
                        const Vec3<T>& from) const {
    const Particles<T>& to = s.particles;
    particle.store(to.x, now.x);
    particle.store(to.v, now.v);
    particle.store(to.F_E, now.material.F_E);
    particle.store_tau(now.material.stress.tau);
    to.J_P[particle.p] = now.material.J_P;
    if constexpr (X::keeps_C) particle.store(to.C, now.C);
    if constexpr (X::modes > 4) {
      Vec3<T> kept;
      if constexpr (X::squares) {
        for (int a = 0; a < 3; ++a)
          kept[a] = X::template kept<S>(fraction(from[a], a), fraction(now.x[a], a));
      }
      for (int n = 4; n < X::modes; ++n)
        particle.store(to.modes + 3 * (n - 4), X::template coefficient<S>(n, sum[n], kept));
    }
  }
  NEVE_INLINE T fraction(T x, int axis) const {
    const T u = frame.local(x, axis);
    return u - floor(u);
  }
};

// Move the particles by one step; without `commit` only report what the step would do to them.
template <class C>
inline void g2p(const Step<typename C::T>& s) {
  using T = typename C::T;
  if (halted(s)) return;
  __shared__ Quad<T> tile[tile_nodes], change[C::has_change ? tile_nodes : 1];
  __shared__ Marks marks;
  __shared__ BlockExchange<typename C::Number> exchange;
  const Home& home = s.nodes.homes[blockIdx.x];
  load_tile(tile, s.nodes.node, home);
  if constexpr (C::has_change) load_tile(change, s.nodes.change, home);
  if constexpr (C::has_solids) {
    exchange.clear();
    mark_near(s, home.at, T(3.5), T(7.1), marks);
  }
  __syncthreads();
  const auto frame = TileFrame<T>::template of<typename C::Spline>(s.constants.step, home.at);
  const auto step = constants_of(s);
  const HomeGather<C> from{s, step, frame, tile, change};
  Seen<T> seen;
  for (unsigned i = threadIdx.x; i < home.count; i += blockDim.x) {
    const std::size_t p = std::size_t(home.begin) + i;
    if constexpr (C::has_solids) {
      from.advance_one(p, NearSolids<T>{s.solids, s.solid_count, marks}, exchange, seen);
    } else {
      from.advance_one(p, NoSolids<T>{}, exchange, seen);
    }
  }
  seen.template publish_from<gather_threads>(*s.results);
  if constexpr (C::has_solids) {
    __syncthreads();
    if (s.commit != 0) exchange.publish(exchanged_of<C>(s), s.solid_count);
  }
}

// s_p += sum_i w_ip (change of s_i). Before the particles move.
template <class C>
inline void gather_lift(const Step<typename C::T>& s) {
  using T = typename C::T;
  using S = typename C::Spline;
  constexpr int first = 3 * (C::Transfer::modes - 4);
  if (halted(s)) return;
  __shared__ Quad<T> tile[tile_nodes];
  const Home& home = s.nodes.homes[blockIdx.x];
  load_tile(tile, s.nodes.lift, home);
  __syncthreads();
  const auto frame = TileFrame<T>::template of<S>(s.constants.step, home.at);
  for (unsigned i = threadIdx.x; i < home.count; i += blockDim.x) {
    const Particle<T> particle{s.particles, std::size_t(home.begin) + i};
    Stencil<T, S, GradientWeights> at;
    at.fill(frame, particle.x());
    Vec3<T> sum[1];
    gather(tile, at, sum);
    particle.store(s.particles.modes + first, particle.mode(first) + sum[0]);
  }
}

}  // namespace neve::cuda
