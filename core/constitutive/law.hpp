// What a constitutive law is to the rest of the core.
//
// A law is a struct, generic over its real type R (a scalar or a lane pack), with
//
//   Parameters<R>                           the constants of one snow;
//                                           Law::parameters(record, stiffness, strength) makes them
//   return_map(F_trial, J_P, parameters)    the plastic update: F_E, J_P, and the stress in the new state
//   stress(F_E, J_P, parameters)            the stress alone, of a state that is not to change
//   energy(F_E, J_P, parameters)            Psi, elastic energy per rest volume [J/m3]
//
// A stress is a Kirchhoff stress tau = P F_E^T [Pa]; `modulus` is the largest acoustic modulus of the present, hardened
// state [Pa], from which the time step is chosen. Every law has one internal variable, J_P = det F_P, and conserves
// J_E J_P. To add a law: one header here, its name in LawName, its line in
// mpm/material.hpp and its word in bind/snow.hpp.
#pragma once

#include "math/svd3.hpp"

namespace neve {

enum class LawName { stomakhin2013, neo_hookean, hencky, drucker_prager, cam_clay };

// One snow, as the scene gives it. The material table is an array of these; each law reads its own constants.
struct Snow {
  LawName law = LawName::stomakhin2013;
  bool plastic = true;  // for the elastic laws: clamp and harden, or elasticity alone
  double E0 = 0, nu = 0, rho0 = 0;
  double xi = 0, theta_c = 0, theta_s = 0, J_P_min = 0, J_P_max = 0;
  double friction_angle = 0, cohesion = 0;  // [degrees], [Pa]
  double sine = 0;                          // of friction_angle: laws make their parameters for every pack
  double M = 0, beta = 0, p0 = 0;           // [1], [1], [Pa]
};

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
