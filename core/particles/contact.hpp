// The force between two particles: elastic, cohesive, rubbing (docs/particles.md).
#pragma once

#include "math/mat3.hpp"

namespace neve {

// A pair i, j seen from i: n points from j to i.
template <class R>
struct Pair {
  Vec3<R> n;    // [1]
  R overlap;    // of the two spheres, below zero: a gap [m]
  R k;          // stiffness of the contact [N/m]
  R v_n;        // speed at which they part [m/s]
  Vec3<R> v_t;  // velocity of i past j [m/s]
};

// What is remembered of a pair. Nothing: `hold` is zero. A bond: `hold` is above zero, the stretch at which it breaks [m],
// and a.x the overlap at which it was made. A contact: `hold` is below zero, less the gap that its cohesion bridges [m],
// and a the spring of its friction [m].
template <class R>
struct Memory {
  R hold;
  Vec3<R> a;
};

// What all contacts of a run share.
template <class T>
struct ContactLaw {
  T damping{};     // of bonds and dry contacts: their damper over their stiffness [s]
  T tangential{};  // stiffness along a contact over that across it [1]
  T dt{};          // for which the velocities have moved the particles since the last call [s]
};

// A contact without cohesion: so small a gap that none is bridged.
template <class T>
inline constexpr T loose = std::numeric_limits<T>::min();

// Where two particles are to each other: x from j to i. Of the pair they make, what does not depend on how they move.
template <class R>
inline Pair<R> pair_at(const Vec3<R>& x, const R& radii) {
  const R tiny = splat<R>(std::numeric_limits<scalar_t<R>>::min());
  const R d2 = dot(x, x);
  const R inv = rsqrt(R(max(d2, tiny)));  // two in one place push nowhere
  Pair<R> pair{};
  pair.n = x * inv, pair.overlap = radii - d2 * inv;
  return pair;
}
// The rest of it: i moves with v past j.
template <class R>
inline void set_motion(Pair<R>& pair, const Vec3<R>& v, const R& k) {
  pair.k = k, pair.v_n = dot(v, pair.n), pair.v_t = v - pair.n * pair.v_n;
}

// Force across a bond [N], positive: apart.
template <class R>
inline R bond_force(const Pair<R>& pair, const R& rest, const ContactLaw<scalar_t<R>>& law) {
  return pair.k * (pair.overlap - rest - pair.v_n * law.damping);
}

// Damping ratio of a contact with water: so a drop keeps less than a tenth of its speed [1].
inline constexpr double ratio_of_water = 1.5;

// Damper of a contact over its stiffness [s], if the share `wet` of what touches is liquid, for particles of masses m_i, m_j [kg].
template <class R>
inline R damper_time(const R& wet, const R& m_i, const R& m_j, const R& k,
                     const ContactLaw<scalar_t<R>>& law) {
  using T = scalar_t<R>;
  const R both = k * (m_i + m_j), tiny = splat<R>(std::numeric_limits<T>::min());
  const R critical = sqrt(R(m_i * m_j / max(both, tiny))) * T(2);
  return max(R(wet * critical * T(ratio_of_water)), splat<R>(law.damping));
}

// Force across a contact whose damper over its stiffness is `time` [N]: where the spheres overlap it never pulls, in a gap
// that cohesion bridges it does.
template <class R>
inline R contact_force(const Pair<R>& pair, const R& time) {
  const R elastic = pair.k * pair.overlap, damped = elastic - pair.k * pair.v_n * time;
  return select(pair.overlap > scalar_t<R>(0), max(damped, splat<R>(0)), elastic);
}

// Turn the spring of friction on, let it slip where it is stronger than mu times the force across, and return the force
// along the contact [N]. The damper acts only where both together hold: so neither gives back more than it took.
template <class R>
inline Vec3<R> rub(Vec3<R>& spring, const Pair<R>& pair, const R& pressed, const R& mu,
                   const ContactLaw<scalar_t<R>>& law) {
  const R zero = splat<R>(0), one = splat<R>(1);
  const R stiff = pair.k * law.tangential, most = mu * max(pressed, zero);
  spring = spring + pair.v_t * law.dt;
  spring = spring - pair.n * dot(spring, pair.n);
  const R pull = stiff * sqrt(R(dot(spring, spring)));
  spring = spring * select(pull > most, R(most / select(pull > zero, pull, one)), one);
  const Vec3<R> elastic = spring * R(-stiff), both = elastic - pair.v_t * R(pair.k * law.damping);
  return select(dot(both, both) <= most * most, both, elastic);
}

}  // namespace neve
