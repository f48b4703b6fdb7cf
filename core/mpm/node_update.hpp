// What a step does to the velocity of one node, from values to values (Stomakhin et al. 2013, section 4.1, steps 4 to 6;
// explicit, so that there is no system to solve in step 6). Collisions with solids, step 5, are in coupling/contacts.hpp.
//
// R is a number, or a row of numbers: the components of several nodes at once.
#pragma once

#include "math/real.hpp"

namespace neve {

// Whether a node has a velocity. One without mass has none, nor one whose mass is denormal (its weight is below 1e-30),
// since 1 / m would overflow.
template <class R>
NEVE_INLINE auto has_velocity(const R& m) {
  using T = scalar_t<R>;
  return m >= std::numeric_limits<T>::min() * T(4);
}

template <class R>
NEVE_INLINE R inverse_mass(const R& m) {
  return scalar_t<R>(1) / select(has_velocity(m), m, splat<R>(1));
}

// 4. One component of dt (g + f / m), the change of velocity by gravity and force.
template <class R>
NEVE_INLINE R velocity_change(const R& dt_g, const R& force, const R& inverse_m, scalar_t<R> dt) {
  return dt_g + force * inverse_m * dt;
}

// One component of v = (m v)^n / m + change.
template <class R>
NEVE_INLINE R node_velocity(const R& momentum, const R& inverse_m, const R& change) {
  return momentum * inverse_m + change;
}

}  // namespace neve
