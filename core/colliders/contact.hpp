// What a solid does to a velocity that meets it (Stomakhin et al. 2013, section 8; METHODS 3.2).
#pragma once

#include "math/mat3.hpp"

namespace neve {

// sticky:   snow takes the body's velocity.
// slip:     snow never leaves nor enters the surface; Coulomb friction while it is pressed on.
// separate: snow may leave; Coulomb friction while it is pressed on.
enum class Contact { sticky, slip, separate };

// The velocity after contact of snow that moves with `v` at a surface of unit normal n that moves with `v_co`.
template <class T>
inline Vec3<T> after_contact(const Vec3<T>& v, const Vec3<T>& n, const Vec3<T>& v_co, Contact mode, T mu_c) {
  if (mode == Contact::sticky) return v_co;
  const Vec3<T> v_rel = v - v_co;
  const T v_n = dot(v_rel, n);
  if (v_n >= T(0) && mode == Contact::separate) return v;
  const Vec3<T> v_t = v_rel - n * v_n;
  if (v_n >= T(0)) return v_t + v_co;
  const T speed = std::sqrt(dot(v_t, v_t));
  if (speed <= -mu_c * v_n) return v_co;
  return v_t * (T(1) + mu_c * v_n / speed) + v_co;
}

}  // namespace neve
