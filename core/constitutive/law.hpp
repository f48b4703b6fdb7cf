// What a constitutive law is to the rest of the core.
//
// A law is a struct, generic over its real type R (a scalar or a lane pack), with
//
//   Parameters<R>                           the constants of one snow; Law::parameters(record, stiffness) makes them
//   return_map(F_trial, J_P, parameters)    the plastic update: F_E, J_P, and the stress in the new state
//   stress(F_E, J_P, parameters)            the stress alone, of a state that is not to change
//   energy(F_E, J_P, parameters)            Psi, elastic energy per rest volume [J/m3]
//
// A stress is a Kirchhoff stress tau = P F_E^T [Pa]; `modulus` is the P-wave modulus of the present, hardened state
// [Pa], from which the time step is chosen. To add a law: one header here, and the choice in mpm/choices.hpp.
#pragma once

#include "math/svd3.hpp"

namespace neve {

// One snow, as the scene gives it. The material table is an array of these.
struct Snow {
  double E0, nu, xi, theta_c, theta_s, rho0, J_P_min, J_P_max;
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

}  // namespace neve
