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

#include "constitutive/law.hpp"

namespace neve {

inline constexpr double ice_density = 917;         // [kg/m3]
inline constexpr double ice_bulk_modulus = 8.9e9;  // [Pa]
inline constexpr double ice_full_strain = 0.1;     // z_s
inline constexpr double most_without_ice = 0.9;    // J that no snow is ice at
inline constexpr double least_ice_volume = 1e-4;   // over J_ice: logarithms stop there

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
  R energy(R z) const {
    const R u = min(R(z / z_s), splat<R>(1)), u2 = u * u, past = max(R(z - z_s), splat<R>(0));
    return J_ice * K * (T(0.05) * z_s * z_s * u2 * u2 * u + past * (T(0.25) * z_s + T(0.5) * past));
  }
  // rho0 c^2 of a pressure wave, J dp_Cauchy/dz.
  R modulus(R z) const {
    const R u = min(R(z / z_s), splat<R>(1));
    return J_ice * K * u * u * u + pressure(z);
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

// Add the stress of ice to what deforms from J_before to J, where `here`. The modulus is that of where it will be after
// one more step like this: the next one is chosen by it.
template <class R, class M>
NEVE_INLINE void add_ice(const Ice<R>& ice, const R& J, const R& J_before, const M& here, Stress<R>& stress) {
  const R zero = splat<R>(0), z = ice.beyond(J), ahead = z + max(R(z - ice.beyond(J_before)), zero);
  const R pressure = ice.pressure(max(z, zero));
  stress.tau.xx = select(here, R(stress.tau.xx - pressure), stress.tau.xx);
  stress.tau.yy = select(here, R(stress.tau.yy - pressure), stress.tau.yy);
  stress.tau.zz = select(here, R(stress.tau.zz - pressure), stress.tau.zz);
  stress.modulus = select(here, R(stress.modulus + ice.modulus(max(ahead, zero))), stress.modulus);
}

}  // namespace neve
