// What all laws share: an isotropic response lives on the principal stretches sigma of F_E = U diag(sigma) V^T.
//
// An elasticity is a struct with two functions of the principal strains sigma - 1 (precise near zero) and of the
// Lame constants mu and lam:
//
//   respond(strain, mu, lam)   tau_k = sigma_k dPsi/dsigma_k, and the largest acoustic modulus
//   energy(strain, mu, lam)    Psi [J/m3]
//
// The acoustic modulus of direction n and polarisation a is a_i n_j C_ijkl a_k n_l, C the spatial tangent of tau per
// rest volume: rho0 c^2 of that wave [Pa]. Along the principal axis k it is sigma_k^2 Psi_kk for a P wave and
// sigma_k^2 (tau_k - tau_l) / (sigma_k^2 - sigma_l^2) for a shear wave towards l.
#pragma once

#include "constitutive/law.hpp"

namespace neve {

// Below this stretch logarithms stop: a step that turns a particle inside out gives large, finite numbers.
inline constexpr double least_stretch = 1e-4;

// Largest yield pressure, in compression or tension, over the bulk modulus: elastic strains stay moderate.
inline constexpr double most_yield = 0.1;

template <class R>
struct Response {
  R isotropic;  // tau_k = isotropic + axial_k [Pa]
  Vec3<R> axial;
  R modulus;
};

struct Lame {
  double mu, lam, K;
};
inline Lame lame(const ElasticConstants& snow) {
  const double mu = snow.E0 / (2 * (1 + snow.nu));
  const double lam = snow.E0 * snow.nu / ((1 + snow.nu) * (1 - 2 * snow.nu));
  return {mu, lam, lam + 2 * mu / 3};
}

// tau = U diag(tau_k) U^T. The isotropic part stays out of the products, so that shear stresses keep their digits.
template <class R>
NEVE_INLINE Stress<R> in_frame(const Mat3<R>& U, const Response<R>& r) {
  const R zero = splat<R>(0);
  Sym3<R> tau{r.isotropic, r.isotropic, r.isotropic, zero, zero, zero};
  for (int k = 0; k < 3; ++k) {
    const Vec3<R>& u = U.column(k);
    const Vec3<R> t = u * r.axial[k];
    tau.xx += t.x * u.x;
    tau.yy += t.y * u.y;
    tau.zz += t.z * u.z;
    tau.xy += t.x * u.y;
    tau.xz += t.x * u.z;
    tau.yz += t.y * u.z;
  }
  return {tau, r.modulus};
}

// F_E = U diag(sigma - excess) V^T as F - U diag(excess) V^T: a lane without excess keeps F to the bit.
template <class R>
NEVE_INLINE Mat3<R> without(const Mat3<R>& F, const Svd3<R>& svd, const Vec3<R>& excess) {
  Mat3<R> out = F;
  for (int k = 0; k < 3; ++k) {
    const Vec3<R> u = svd.U.column(k) * excess[k];
    out.c0 = out.c0 - u * svd.V.column(k).x;
    out.c1 = out.c1 - u * svd.V.column(k).y;
    out.c2 = out.c2 - u * svd.V.column(k).z;
  }
  return out;
}

// J - 1 from the principal strains, without the cancellation of the product.
template <class R>
NEVE_INLINE R volume_change(const Vec3<R>& e) {
  return e.x + e.y + e.z + e.x * e.y + e.x * e.z + e.y * e.z + e.x * e.y * e.z;
}

template <class R>
NEVE_INLINE R largest(const Vec3<R>& a) {
  return max(max(a.x, a.y), a.z);
}
template <class R>
NEVE_INLINE R smallest(const Vec3<R>& a) {
  return min(min(a.x, a.y), a.z);
}

}  // namespace neve
