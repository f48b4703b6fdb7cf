// Ice: what snow is when its grains leave no room between them.
//
//   U(J) = J_ice K z_s^2 / 20 (z / z_s)^5,   p = dU/dz = J_ice K z_s / 4 (z / z_s)^4,   z = max(ln(J_ice / J), 0)
//
// A further elastic energy of the volume change J = J_E J_P alone, beside that of any law with plastic flow: whatever is
// F_E and whatever F_P, snow that is as dense as ice resists as ice does. Flow keeps J, so it makes no energy. J_ice is
// the volume of ice per volume at rest. Its bulk modulus grows from 0 to that of ice, K, at z = z_s, and is K beyond:
// snow that comes to rest at the density of ice is about as stiff as its load asks for, and takes steps to match.
//
// J_ice = m / (V0 917 kg/m3) is the particle's own; but every snow may be pressed to nine tenths of its volume, even if it
// is given the density of ice or a higher one.
//
// K = 8.9 GPa follows from the elastic constants of ice Ih at -16 C, c11, c12, c13, c33 = 13.93, 7.08, 5.77, 15.01 GPa
// (Gammon et al. 1983, abstract): (2 (c11 + c12) + 4 c13 + c33) / 9; it is 8.7 GPa at -3 C. The density is that at 0 C.
// z_s is our choice.
#pragma once

#include "constitutive/densities.hpp"
#include "constitutive/law.hpp"

namespace neve {

inline constexpr double ice_bulk_modulus = 8.9e9;  // [Pa]
inline constexpr double ice_full_strain = 0.1;     // z_s
inline constexpr double most_without_ice = 0.9;    // J that no snow is ice at
inline constexpr double least_ice_volume = 1e-4;   // over J_ice: logarithms stop there
inline constexpr double ice_caution = 2;  // on the modulus: steps in ice end at w dt = 1, not at sqrt 2

template <class R>
struct Ice {
  R J_ice;
  using T = scalar_t<R>;
  static constexpr T K = T(ice_bulk_modulus), z_s = T(ice_full_strain);

  static Ice of(R m, R V0) {
    return {min(R(m / max(R(V0 * T(ice_density)), splat<R>(std::numeric_limits<T>::min()))),
                splat<R>(T(most_without_ice)))};
  }

  // z, below 0 where snow is lighter than ice.
  R beyond(R J) const {
    const R one = splat<R>(1);
    return -log1p(R(max(R(J / J_ice), splat<R>(T(least_ice_volume))) - one));
  }

  // Of z >= 0.
  R pressure(R z) const {
    const R u = min(R(z / z_s), splat<R>(1)), u2 = u * u;
    return J_ice * K * (T(0.25) * z_s * u2 * u2 + max(R(z - z_s), splat<R>(0)));
  }
  // dp/dz
  R slope(R z) const {
    const R u = min(R(z / z_s), splat<R>(1));
    return J_ice * K * (u * u * u);
  }
  R energy(R z) const {
    const R u = min(R(z / z_s), splat<R>(1)), u2 = u * u, past = max(R(z - z_s), splat<R>(0));
    return J_ice * K * (T(0.05) * z_s * z_s * u2 * u2 * u + past * (T(0.25) * z_s + T(0.5) * past));
  }
  // rho0 c^2 = dp/dz + p of a pressure wave where a blow ends that has taken ice to z >= 0 and changes z by
  // `speed` / dx in a second: where the elastic energy is U(z) and J_ice 917 kg/m3 speed^2 / 2 besides. An upper
  // bound: with y this energy over that at z_s, (z / z_s)^3 = y^(3/5) <= y^(19/32).
  R modulus_to_come(R z, R speed) const {
    constexpr T whole = T(0.05) * K * z_s * z_s, density = T(ice_density);
    const R one = splat<R>(1), y = (energy(z) / J_ice + T(0.5) * density * speed * speed) / whole;
    const R y2 = sqrt(min(y, one)), y16 = sqrt(sqrt(sqrt(y2)));
    const R past = sqrt(T(0.0625) + T(0.1) * max(R(y - one), splat<R>(0))) - T(0.25);
    return J_ice * K * (y2 * y16 * sqrt(y16) * (T(1) + T(0.25) * z_s) + z_s * past);
  }
};

// J over that at which snow of mass m and rest volume V0 is ice.
template <class R>
NEVE_INLINE R ice_room(const R& J, const R& m, const R& V0) {
  using T = scalar_t<R>;
  const R lighter = J * V0 * T(ice_density) / select(m > T(0), m, splat<R>(1));
  return max(lighter, R(J / T(most_without_ice)));
}

// What is at, or within a tenth of, ice.
template <class R>
NEVE_INLINE auto near_ice(const R& room) {
  return room < splat<R>(scalar_t<R>(1.1));
}

// Add the stress of ice to what deforms from J_before to J in dx / `cell_speed`, where `here`.
//
// The modulus, by which the next step is chosen, is that of where the blow will end, times ice_caution, as soon as one
// more step like this one would lead into ice and until all has left it. Stiffness that comes from nothing and goes
// again needs both: steps that change while the stress p works add p |dz/dt| / 2 times their change to the energy, on the
// way in and out alike; and a step that meets, or leaves, a stiff spring on its way may add (w dt)^2 / 4 of it.
template <class R, class M>
NEVE_INLINE void add_ice(const Ice<R>& ice, const R& J, const R& J_before, scalar_t<R> cell_speed,
                         const M& here, Stress<R>& stress) {
  using T = scalar_t<R>;
  const R zero = splat<R>(0), z = ice.beyond(J), change = z - ice.beyond(J_before);
  const R within = max(z, zero), pressure = ice.pressure(within);
  const R modulus = ice.modulus_to_come(within, change * cell_speed) * T(ice_caution);
  const auto meets = here & (z + max(change, zero) > zero);
  stress.tau.xx = select(here, R(stress.tau.xx - pressure), stress.tau.xx);
  stress.tau.yy = select(here, R(stress.tau.yy - pressure), stress.tau.yy);
  stress.tau.zz = select(here, R(stress.tau.zz - pressure), stress.tau.zz);
  stress.modulus = select(meets, R(stress.modulus + modulus), stress.modulus);
}

}  // namespace neve
