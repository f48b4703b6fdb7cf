// What a viewer shows of the particles: positions and the values of a colour mode, in 16 bits each, so that eight bytes of a
// particle are copied instead of the columns that they come from.
#pragma once

#include "cuda/grid/reduce.hpp"
#include "cuda/particle.hpp"

namespace neve::cuda {

inline constexpr int picture_threads = 128;
inline constexpr unsigned most_word = 65534, no_word = 65535;

// The von Mises stress sqrt(3/2 s:s) / J_E of the deviator s of tau [Pa].
template <class T>
inline T von_mises(const Sym3<T>& tau, T J_E) {
  const T a = tau.xx - tau.yy, b = tau.yy - tau.zz, c = tau.zz - tau.xx;
  const T square =
      T(0.5) * (a * a + b * b + c * c) + T(3) * (tau.xy * tau.xy + tau.xz * tau.xz + tau.yz * tau.yz);
  return sqrt(square) / max(abs(J_E), T(1e-3));
}

// What the colour shows of a particle.
template <class T>
inline T shade_of(const Step<T>& s, std::size_t p) {
  const Particle<T> particle{s.particles, p};
  switch (Shade(s.picture.shade)) {
    case Shade::speed: {
      const Vec3<T> v = particle.v();
      return sqrt(dot(v, v));
    }
    case Shade::J_P: return particle.J_P();
    case Shade::density:
      return particle.m() / (particle.V0() * max(determinant(particle.F_E()) * particle.J_P(), T(1e-3)));
    case Shade::stress: return von_mises(particle.tau(), determinant(particle.F_E()));
    case Shade::material: return T(s.particles.material[p]);
    case Shade::none: break;
  }
  return T(0);
}

// Their ends: results.most holds the largest x, -x, y, -y, z, -z, value and -value. What is not finite does not count.
template <class T>
inline void picture_ends(const Step<T>& s) {
  const unsigned p = blockIdx.x * blockDim.x + threadIdx.x;
  constexpr T least = -std::numeric_limits<T>::max();
  T most[8] = {least, least, least, least, least, least, least, least};
  if (p < s.particle_count) {
    const Vec3<T> x = Particle<T>{s.particles, p}.x();
    const T all[] = {x.x, x.y, x.z, shade_of(s, p)};
    for (int k = 0; k < 4; ++k) {
      if (all[k] - all[k] == T(0)) most[2 * k] = all[k], most[2 * k + 1] = -all[k];
    }
  }
  block_max<picture_threads>(most);
  if (threadIdx.x == 0) publish(*s.results, 0, most);
}

// low + step q is about the number; a particle without finite numbers has q = (65535, 65535, 65535), and is not drawn.
template <class T>
inline void draw_picture(const Step<T>& s) {
  const unsigned p = blockIdx.x * blockDim.x + threadIdx.x;
  if (p >= s.particle_count) return;
  const Vec3<T> x = Particle<T>{s.particles, p}.x();
  const T all[] = {x.x, x.y, x.z, shade_of(s, p)}, sum = x.x + x.y + x.z;
  const bool lost = !(sum - sum == T(0));
  for (int k = 0; k < 4; ++k) {
    const double q = (double(all[k]) - s.picture.low[k]) * s.picture.per_step[k] + 0.5;
    unsigned word = q > 0 ? (q < double(most_word) ? unsigned(q) : most_word) : 0;
    if (lost && k < 3) word = no_word;
    s.picture.words[4 * std::size_t(p) + unsigned(k)] = static_cast<unsigned short>(word);
  }
}

}  // namespace neve::cuda
