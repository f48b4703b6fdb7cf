// What is asked of all particles between steps: whether each is such as snow can be, and sums for the log. A thread per
// particle.
#pragma once

#include "cuda/grid/reduce.hpp"
#include "cuda/grid/stencil.hpp"
#include "cuda/particle.hpp"
#include "mpm/energy.hpp"

namespace neve::cuda {

inline constexpr int sum_threads = 128;

// Whether a particle is all right beyond doubt, as sound() of cpu/passes/inspect.hpp.
template <class C>
inline bool is_sound(const Step<typename C::T>& s, std::size_t p) {
  using T = typename C::T;
  const Particle<T> particle{s.particles, p};
  const Mat3<T> F = particle.F_E(), G = particle.C();
  const Vec3<T> x = particle.x(), v = particle.v();
  const T strength = s.particles.strength[p],
          positive[] = {particle.J_P(), particle.m(), particle.V0(), s.particles.stiffness[p]};
  T differ = strength - strength;  // 0, or not a number
  for (int k = 0; k < 3; ++k) differ += (x[k] - x[k]) + (v[k] - v[k]);
  for (int k = 0; k < 9; ++k)
    differ += (F(k % 3, k / 3) - F(k % 3, k / 3)) + (G(k % 3, k / 3) - G(k % 3, k / 3));
  constexpr int columns = 3 * (C::Transfer::modes - 4) + 3 * C::has_play;
  for (int k = 0; k < columns; ++k) differ += s.particles.modes[k][p] - s.particles.modes[k][p];
  bool good = differ == T(0) && strength >= T(0) && s.particles.material[p] < s.snow_count;
  for (T a : positive) good = good && a > T(0) && a - a == T(0);
  const T norm2 = dot(F.c0, F.c0) + dot(F.c1, F.c1) + dot(F.c2, F.c2);
  return good && determinant(F) > norm2 * sqrt(norm2) * (T(16) * std::numeric_limits<T>::epsilon());
}

// Tell whether some particle may be impossible, and which is the densest over the ice that it may become: the number as
// a float, then the row turned round, so that of equals the first counts.
template <class C>
inline void inspect(const Step<typename C::T>& s) {
  using T = typename C::T;
  const unsigned p = blockIdx.x * blockDim.x + threadIdx.x;
  if (p >= s.particle_count) return;
  if (!is_sound<C>(s, p)) {
    s.sums->doubtful = 1;
    return;
  }
  if (!s.snows[s.particles.material[p]].plastic) return;
  const Particle<T> particle{s.particles, p};
  const float crowding =
      float(Ice<T>::of(particle.m(), particle.V0()).J_ice / (determinant(particle.F_E()) * particle.J_P()));
  unsigned bits;
  std::memcpy(&bits, &crowding, sizeof(bits));  // of numbers above 0 the larger has the larger bits
  atomicMax(&s.sums->densest, BlockKey(bits) << 32 | BlockKey(~p));
}

// Kinetic energy per mass of a particle's velocity modes but the first [J/kg].
template <class C>
inline double affine_energy(const Step<typename C::T>& s, std::size_t p) {
  using T = typename C::T;
  if constexpr (C::Transfer::keeps_C) {
    const Particle<T> particle{s.particles, p};
    const double dx = double(s.constants.step.cells.dx);
    const Mat3<T> G = particle.C();
    const Vec3<T> x = particle.x();
    double whole[9], fraction[3];
    for (int k = 0; k < 9; ++k) whole[k] = dx * double(G(k % 3, k / 3));
    for (int a = 0; a < 3; ++a) {
      const double u = double(x[a]) / dx - C::Spline::shift;
      fraction[a] = u - floor(u);
    }
    return modes_energy<typename C::Spline, typename C::Transfer>(
        whole, fraction, [&](int k) { return double(s.particles.modes[k][p]); });
  } else {
    return 0;
  }
}

// Sums in double.
template <class C>
inline void add_up(const Step<typename C::T>& s) {
  using T = typename C::T;
  const unsigned p = blockIdx.x * blockDim.x + threadIdx.x;
  double sum[8] = {};  // as in Sums
  if (p < s.particle_count) {
    const Particle<T> particle{s.particles, p};
    const Vec3<T> x = particle.x(), v = particle.v();
    const double m = double(particle.m());
    double v2 = 0, gx = 0;
    for (int k = 0; k < 3; ++k) {
      sum[1 + k] = m * double(v[k]);
      v2 += double(v[k]) * double(v[k]);
      gx += double(s.constants.gravity[k]) * double(x[k]);
    }
    const Material<T, C::laws> material{s, p};
    sum[0] = m, sum[4] = 0.5 * m * v2, sum[5] = m * affine_energy<C>(s, p);
    sum[6] = double(material.energy(particle.F_E(), particle.J_P())) * double(particle.V0());
    sum[7] = -m * gx;
  }
  auto* to = reinterpret_cast<typename C::Number*>(s.sums->number);
  if constexpr (C::is_deterministic) {  // whichever particles a block of threads has
    __shared__ typename C::Number of_block[8];
    if (threadIdx.x < 8) of_block[threadIdx.x].clear();
    __syncthreads();
    for (int k = 0; k < 8; ++k) of_block[k].add(sum[k]);
    __syncthreads();
    if (threadIdx.x < 8) to[threadIdx.x].add(of_block[threadIdx.x]);
  } else {
    block_sum<sum_threads>(sum);
    if (threadIdx.x == 0) {
      for (int k = 0; k < 8; ++k) to[k].add(sum[k]);
    }
  }
}

}  // namespace neve::cuda
