// What a constitutive law is to the rest of the core.
//
// A law is a struct, generic over its real type R (a scalar or a lane pack), with
//
//   Parameters<R>                           the constants of one snow;
//                                           Law::parameters(record, stiffness, strength) makes them
//   return_map(F_trial, J_P, parameters)    the plastic update: F_E, J_P, and the stress in the new state
//   stress(F_E, J_P, parameters)            the stress alone, of a state that is not to change
//   energy(F_E, J_P, parameters)            Psi, elastic energy per rest volume [J/m3]
//   tangent(strain, J_P, parameters)        its second derivatives, of the principal strains of F_E (tangent.hpp)
//
// and it publishes, for scenes, documents and random trials,
//
//   word                                    its name, meaning, source and papers
//   Constants, constants                    its constants as numbers, and what each of them is
//   has_elastic_option                      whether plasticity = "none" leaves its elasticity alone
//   compacts                                whether J_P below 1 is snow pressed for good
//   plasticity_cites                        the papers of its plastic flow, if they are not the law's own
//   limit, most_strength(c)                 the largest factor that its thresholds may have, and why
//   max_compression(c, strongest)           how far one step may compress the snow: -dt tr grad v [1]
//   hardening_exponent(c)                   the largest exponent of its hardening [1]
//
// A stress is a Kirchhoff stress tau = P F_E^T [Pa]; `modulus` is the largest acoustic modulus of the present, hardened
// state [Pa], from which the time step is chosen. Every law has one internal variable, J_P = det F_P, and conserves
// J_E J_P. To add a law: one header here and its line in laws.hpp.
#pragma once

#include "math/list.hpp"
#include "math/mat3.hpp"

namespace neve {

// What every snow has.
struct ElasticConstants {
  double rho0, E0, nu;
};
// Lame's constants and the bulk modulus that follow [Pa].
struct Lame {
  double mu, lam, K;
};
inline Lame lame(const ElasticConstants& snow) {
  const double mu = snow.E0 / (2 * (1 + snow.nu));
  const double lam = snow.E0 * snow.nu / ((1 + snow.nu) * (1 - 2 * snow.nu));
  return {mu, lam, lam + 2 * mu / 3};
}

// One snow, as the scene gives it: its law's Constants. The material table is an array of these.
struct Snow {
  int law = 0;          // place in Laws
  bool plastic = true;  // for laws with an elastic option: whether they flow
  Lame lame{};          // divided out once, not for each pack

  template <class C>
  NEVE_INLINE C constants() const {
    static_assert(sizeof(C) <= sizeof(numbers_));
    C c;
    std::memcpy(&c, numbers_, sizeof(C));
    return c;
  }
  template <class C>
  void set(const C& c) {
    static_assert(sizeof(C) <= sizeof(numbers_));
    std::memcpy(numbers_, &c, sizeof(C));
    lame = neve::lame(c);
  }

 private:
  double numbers_[16] = {};
};

// Numbers from `low` to `high`, without the ends that are open.
struct Range {
  double low, high;
  bool open_low = false, open_high = false;
};

// What a constant does: shape the elasticity; the flow; or be a threshold of the flow, which `strength` multiplies.
enum class Role { elastic, plastic, threshold };

// What a law says about one of its constants.
template <class C>
struct Constant {
  const char* name;
  double C::* member;
  double usual;  // its default
  const char* unit;
  Range range;  // what is legal
  Range drawn;  // what random trials take, on a logarithmic scale where it spans a factor of 100
  Role role;
  const char* source;   // of the default
  const char* meaning;  // one sentence
};

template <class C>
constexpr Constant<C> rho0_of(double usual, const char* source) {
  return {"rho0",        &C::rho0,  usual,
          "kg/m3",       {1, 2000}, {1.0, 2000.0},
          Role::elastic, source,    "Density, at least about that of air, in which lighter snow would rise."};
}
template <class C>
constexpr Constant<C> E0_of(double usual, const char* source) {
  return {"E0",          &C::E0,          usual,
          "Pa",          {0, 1e12, true}, {1e2, 1e11},
          Role::elastic, source,          "Young's modulus of snow that is not hardened; larger is icier."};
}
template <class C>
constexpr Constant<C> nu_of(double usual, const char* source) {
  return {"nu",
          &C::nu,
          usual,
          "1",
          {0, 0.5, false, true},
          {0.0, 0.49},
          Role::elastic,
          source,
          "Poisson's ratio."};
}

// The bounds of J_P, which any law may have.
template <class C>
constexpr Constant<C> J_P_min_of(double usual) {
  return {"J_P_min",
          &C::J_P_min,
          usual,
          "1",
          {0, 1, true, true},
          {0.05, 0.97},
          Role::plastic,
          "bounds of the public 88-line MLS-MPM program",
          "Lower bound of J_P inside the hardening alone."};
}
template <class C>
constexpr Constant<C> J_P_max_of(
    double usual,
    const char* meaning = "Upper bound of J_P: grains that fly apart do not remember how far.") {
  return {"J_P_max",      &C::J_P_max, usual,         "1",
          {1, 1e6, true}, {1.01, 1e4}, Role::plastic, "bounds of the public 88-line MLS-MPM program",
          meaning};
}

template <class R>
struct Stress {
  Sym3<R> tau;
  R modulus;
};

template <class R>
struct Mapped {
  Mat3<R> F_E;
  R J_P;
  Stress<R> stress;
};

template <class R, class M>
Stress<R> select(const M& mask, const Stress<R>& a, const Stress<R>& b) {
  return {select(mask, a.tau, b.tau), select(mask, a.modulus, b.modulus)};
}
template <class R, class M>
Mapped<R> select(const M& mask, const Mapped<R>& a, const Mapped<R>& b) {
  return {select(mask, a.F_E, b.F_E), select(mask, a.J_P, b.J_P), select(mask, a.stress, b.stress)};
}

}  // namespace neve
