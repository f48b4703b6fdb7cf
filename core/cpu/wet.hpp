// What heat makes of the stress of snow: a skeleton that goes as it melts, and water beside it (docs/heat.md).
//
// With the share f of water, a particle's energy per volume at rest is (1 - f) Psi_snow + f U_w(J), and what resists as ice
// does comes later:
//
//   U_w(J) = J_i K ((r^7 - 1) / 7 - ln r) / 7,   dU_w / d ln r = J_i K (r^7 - 1) / 7,
//   r = max(J_i / J, 1),   J_i = m / (917 kg/m3 V0)
//
// so that water resists what would press it, at first as stiffly as its snow did, K = E0 / (3 (1 - 2 nu)), and nothing else: it
// has no shear stress and no tension. That it stiffens is the equation of state of Cole 1948 (exponent 7), usual for water
// whose K is too small (Monaghan 1994): what lies under a load is not pressed to ice. Water has the density of ice,
// so that freezing needs no room and makes no pressure. As ice resists what has been water only from (1 - g / 5) J_ice on, g the
// largest f that there was. At a given J neither melting nor freezing gives energy.
#pragma once

#include "constitutive/ice.hpp"
#include "cpu/fields.hpp"
#include "mpm/model.hpp"

namespace neve::detail {

inline constexpr double least_skeleton = 1e-3;  // 1 - f, where it divides
inline constexpr double pressed_water = 0.8;    // J over J_ice from which on it resists as ice does
// J over that of water beyond which water forgets how far it has come apart: spray that falls back fills its pool.
inline constexpr double loose_water = 1.1;

// The liquid share of a pack; nothing without heat.
template <class T>
NEVE_INLINE Lanes<T> liquid_share(const State<T>& state, std::size_t p, int count) {
  return load<Lanes<T>>(state.thermal.column(0) + p, count);
}

// Stiffness and strength of what has not melted, and has sintered.
template <class T>
NEVE_INLINE void weaken(const State<T>& state, std::size_t p, int count, Lanes<T>& stiffness,
                        Lanes<T>& strength) {
  using R = Lanes<T>;
  const R solid = max(splat<R>(1) - liquid_share(state, p, count), splat<R>(T(least_skeleton)));
  stiffness = stiffness * solid;
  strength = strength * solid * load<R>(state.thermal.column(1) + p, count);
}

// J of water, and of ice, of a pack with heat.
template <class T>
NEVE_INLINE Lanes<T> dense_volume(const State<T>& state, std::size_t p, int count) {
  using R = Lanes<T>;
  const R V0 = load<R>(state.V0.column(0) + p, count), m = load<R>(state.m.column(0) + p, count);
  const R least = splat<R>(std::numeric_limits<T>::min());
  return max(R(m / max(R(V0 * T(ice_density)), least)), least);
}

// J at which a pack with heat resists as ice, over that of Ice::of().
template <class T>
NEVE_INLINE Lanes<T> pressed_ratio(const State<T>& state, std::size_t p, int count) {
  using R = Lanes<T>;
  return splat<R>(1) - load<R>(state.thermal.column(2) + p, count) * T(1 - pressed_water);
}

// Water that is pressed to J.
template <class T>
struct PackWater {
  using R = Lanes<T>;
  R strength, pressed;  // f J_i K [Pa]; r - 1 >= 0

  PackWater(const Model<T>& model, const State<T>& state, std::size_t p, int count, const R& J) {
    R K{};
    for (int l = 0; l < count; ++l) {
      const auto& snow = model.snows[state.material[p + static_cast<std::size_t>(l)]];
      const auto given = snow.template constants<ElasticConstants>();
      K[l] = T(given.E0 / (3 * (1 - 2 * given.nu)));
    }
    const R full = dense_volume(state, p, count), least = full * T(least_ice_volume);
    strength = liquid_share(state, p, count) * full * K * load<R>(state.stiffness.column(0) + p, count);
    pressed = max(R((full - J) / max(J, least)), splat<R>(0));
  }
  R pressure() const { return strength * rise(); }
  R modulus() const { return strength * (splat<R>(1) + T(7) * rise()); }
  R energy() const { return strength * (rise() - log1p(pressed)) * T(1.0 / 7); }

 private:
  // (r^7 - 1) / 7, exact for small r - 1.
  R rise() const {
    const R one = splat<R>(1), r = pressed + one;
    return pressed * (one + r * (one + r * (one + r * (one + r * (one + r * (one + r)))))) * T(1.0 / 7);
  }
};

// Add the stress of water to particles with heat. Its modulus counts before it is pressed: a step may press it.
template <class T>
[[gnu::noinline]] void add_water(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                                 const Lanes<T>& J, Stress<Lanes<T>>& stress) {
  using R = Lanes<T>;
  if (!any(liquid_share(state, p, count) > splat<R>(0))) return;
  const PackWater<T> water(model, state, p, count, J);
  const R pressure = water.pressure();
  stress.tau.xx = stress.tau.xx - pressure;
  stress.tau.yy = stress.tau.yy - pressure;
  stress.tau.zz = stress.tau.zz - pressure;
  stress.modulus = stress.modulus + water.modulus();
}

// Water has no shape to return to: F_E = 1, and J_P is its volume. `now`: what the law of its snow makes of it, stress
// included; F_trial and J_P before it.
template <class T>
[[gnu::noinline]] void flow_as_water(const State<T>& state, std::size_t p, int count,
                                     const Mat3<Lanes<T>>& F_trial, const Lanes<T>& J_P,
                                     Mapped<Lanes<T>>& now) {
  using R = Lanes<T>;
  const auto is_water = liquid_share(state, p, count) >= splat<R>(1);
  const R loose = dense_volume(state, p, count) * T(loose_water);
  const R J = min(R(determinant(F_trial) * J_P), max(J_P, loose));
  const R zero = splat<R>(0);
  now = select(is_water, Mapped<R>{identity<R>(), J, {{zero, zero, zero, zero, zero, zero}, zero}}, now);
}

}  // namespace neve::detail
