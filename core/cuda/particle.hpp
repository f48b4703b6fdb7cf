// One particle: its values from the columns and back, and what its law makes of them.
#pragma once

#include "constitutive/ice.hpp"
#include "cuda/choices.hpp"
#include "cuda/grid/views.hpp"

namespace neve::cuda {

template <class T>
struct Particle {
  const Particles<T>& s;
  std::size_t p;

  NEVE_INLINE Vec3<T> vector(T* const* f) const { return {f[0][p], f[1][p], f[2][p]}; }
  NEVE_INLINE Mat3<T> matrix(T* const* f) const {
    return {{f[0][p], f[1][p], f[2][p]}, {f[3][p], f[4][p], f[5][p]}, {f[6][p], f[7][p], f[8][p]}};
  }
  NEVE_INLINE Vec3<T> x() const { return vector(s.x); }
  NEVE_INLINE Vec3<T> v() const { return vector(s.v); }
  NEVE_INLINE Mat3<T> C() const { return matrix(s.C); }
  NEVE_INLINE Mat3<T> F_E() const { return matrix(s.F_E); }
  NEVE_INLINE Sym3<T> tau() const {
    return {s.tau[0][p], s.tau[1][p], s.tau[2][p], s.tau[3][p], s.tau[4][p], s.tau[5][p]};
  }
  NEVE_INLINE T J_P() const { return s.J_P[p]; }
  NEVE_INLINE T m() const { return s.m[p]; }
  NEVE_INLINE T V0() const { return s.V0[p]; }
  NEVE_INLINE Vec3<T> mode(int first) const { return vector(s.modes + first); }

  NEVE_INLINE void store(T* const* f, const Vec3<T>& a) const { f[0][p] = a.x, f[1][p] = a.y, f[2][p] = a.z; }
  NEVE_INLINE void store(T* const* f, const Mat3<T>& a) const {
    store(f, a.c0), store(f + 3, a.c1), store(f + 6, a.c2);
  }
  NEVE_INLINE void store_tau(const Sym3<T>& a) const {
    s.tau[0][p] = a.xx, s.tau[1][p] = a.yy, s.tau[2][p] = a.zz;
    s.tau[3][p] = a.xy, s.tau[4][p] = a.xz, s.tau[5][p] = a.yz;
  }
};

// f(Law{}) for the law at that place of Laws, of which there are those with a bit in `laws`.
template <unsigned laws, int place = 0, class F>
NEVE_INLINE auto with_law_of(int law, F&& f) {
  constexpr unsigned later = laws >> place >> 1;
  if constexpr ((laws >> place & 1u) == 0) {
    return with_law_of<laws, place + 1>(law, f);
  } else {
    if constexpr (later != 0) {
      if (law != place) return with_law_of<laws, place + 1>(law, f);
    }
    return f(item_at<place, Laws>{});
  }
}

// The laws on one particle, with the stress of ice where it comes to that.
template <class T, unsigned laws>
struct Material {
  const Step<T>& s;
  std::size_t p;
  NEVE_INLINE const Snow& snow() const { return s.snows[s.particles.material[p]]; }

  // J over that at which the particle is ice; no bound for snow that does not flow.
  NEVE_INLINE T ice_room(T J) const {
    const Particle<T> particle{s.particles, p};
    return snow().plastic ? neve::ice_room(J, particle.m(), particle.V0()) : std::numeric_limits<T>::max();
  }
  // For a particle that deforms to J in dx / cell_speed; before its F_E and J_P change.
  NEVE_INLINE void add_ice(T J, T cell_speed, Stress<T>& stress) const {
    const Particle<T> particle{s.particles, p};
    const T J_before = determinant(particle.F_E()) * particle.J_P();
    neve::add_ice(Ice<T>::of(particle.m(), particle.V0()), J, J_before, cell_speed, snow().plastic, stress);
  }

  Mapped<T> operator()(const Mat3<T>& F_trial, T J_P) const {
    return with_law_of<laws>(snow().law, [&](auto law) {
      using Law = decltype(law);
      const auto q = Law::parameters(snow(), s.particles.stiffness[p], s.particles.strength[p]);
      return Law::return_map(F_trial, J_P, q);
    });
  }
  T energy(const Mat3<T>& F_E, T J_P) const {
    const T law_energy = with_law_of<laws>(snow().law, [&](auto law) {
      using Law = decltype(law);
      const auto q = Law::parameters(snow(), s.particles.stiffness[p], s.particles.strength[p]);
      return Law::energy(F_E, J_P, q);
    });
    const T J = determinant(F_E) * J_P;
    if (!near_ice(ice_room(J))) return law_energy;  // as is snow that does not flow
    const Particle<T> particle{s.particles, p};
    const auto ice = Ice<T>::of(particle.m(), particle.V0());
    return law_energy + ice.energy(max(ice.beyond(J), T(0)));
  }
  Stress<T> stress(const Mat3<T>& F_E, T J_P) const {
    Stress<T> out = with_law_of<laws>(snow().law, [&](auto law) {
      using Law = decltype(law);
      const auto q = Law::parameters(snow(), s.particles.stiffness[p], s.particles.strength[p]);
      return Law::stress(F_E, J_P, q);
    });
    const T J = determinant(F_E) * J_P;
    if (near_ice(ice_room(J))) add_ice(J, T(0), out);
    return out;
  }
};

}  // namespace neve::cuda
