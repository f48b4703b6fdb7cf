// What all laws share: an isotropic response lives on the principal stretches sigma of F_E = U diag(sigma) V^T.
//
// An elasticity is a struct with three functions of the principal strains sigma - 1 (precise near zero) and of the
// Lame constants mu and lam:
//
//   respond(strain, mu, lam)   tau_k = sigma_k dPsi/dsigma_k, and the largest acoustic modulus
//   energy(strain, mu, lam)    Psi [J/m3]
//   tangent(strain, mu, lam)   its second derivatives (tangent.hpp)
//
// The acoustic modulus of direction n and polarisation a is a_i n_j C_ijkl a_k n_l, C the spatial tangent of tau per
// rest volume: rho0 c^2 of that wave [Pa]. Along the principal axis k it is sigma_k^2 Psi_kk for a P wave and
// sigma_k^2 (tau_k - tau_l) / (sigma_k^2 - sigma_l^2) for a shear wave towards l.
#pragma once

#include "constitutive/law.hpp"
#include "constitutive/small_strain.hpp"
#include "constitutive/tangent.hpp"
#include "math/svd3.hpp"

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

// The principal stretches of F near the identity, and what a law makes of its response to them, as functions of
// B = F F^T - I:
//
//   tau = sum_k tau_k u_k u_k^T
//   F_E = sum_k (sigma_k - excess_k) u_k v_k^T = F - (sum_k excess_k / sigma_k u_k u_k^T) F
//
// The isotropic part of the stress stays out of the products, so that shear stresses keep their digits; and a lane without
// excess keeps F to the bit.
template <class R>
struct Stretches {
  const Mat3<R>& F;
  Spectrum3<R> spectrum;
  Vec3<R> sigma, strain, inverse;  // sigma - 1 precise near zero; 1 / sigma

  NEVE_INLINE Stretches(const Mat3<R>& of, const Spectrum3<R>& its) : F(of), spectrum(its) {
    using T = scalar_t<R>;
    for (int k = 0; k < 3; ++k) {
      const R e = spectrum.e[k], square = e + T(1);
      inverse[k] = rsqrt(square);
      sigma[k] = square * inverse[k];
      strain[k] = e * reciprocal(R(sigma[k] + T(1)));
    }
  }

  NEVE_INLINE Stress<R> stress(const Response<R>& r) const {
    return {r.isotropic + isotropic_function(spectrum, r.axial), r.modulus};
  }

  NEVE_INLINE Mat3<R> without(const Vec3<R>& excess) const {
    const Vec3<R> y{excess.x * inverse.x, excess.y * inverse.y, excess.z * inverse.z};
    const Mat3<R> part = full(isotropic_function(spectrum, y)) * F;
    return {F.c0 - part.c0, F.c1 - part.c1, F.c2 - part.c2};
  }
};

// The same of any F, by its singular value decomposition: far from the identity, or inverted, B has lost digits.
template <class R>
struct FarStretches : Svd3<R> {
  const Mat3<R>& F;

  explicit FarStretches(const Mat3<R>& of) : Svd3<R>(svd3(of)), F(of) {}

  Stress<R> stress(const Response<R>& r) const {
    const R zero = splat<R>(0);
    Sym3<R> tau{r.isotropic, r.isotropic, r.isotropic, zero, zero, zero};
    for (int k = 0; k < 3; ++k) {
      const Vec3<R>& u = this->U.column(k);
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

  Mat3<R> without(const Vec3<R>& excess) const {
    Mat3<R> out = F;
    for (int k = 0; k < 3; ++k) {
      const Vec3<R> u = this->U.column(k) * excess[k];
      const Vec3<R>& v = this->V.column(k);
      out.c0 = out.c0 - u * v.x;
      out.c1 = out.c1 - u * v.y;
      out.c2 = out.c2 - u * v.z;
    }
    return out;
  }
};

namespace detail {
template <class R, class F>
NEVE_RARE auto with_far_stretches(const Mat3<R>& A, F&& f) {
  return f(FarStretches<R>(A));
}
}  // namespace detail

// f(stretches of A), with its strain B.
template <class R, class F>
NEVE_INLINE auto with_stretches(const Mat3<R>& A, const Sym3<R>& B, F&& f) {
  using T = scalar_t<R>;
  const Spectrum3<R> spectrum = spectrum3(B);
  if (any((spectrum.lowest() < splat<R>(T(-0.75))) | (spectrum.highest() > splat<R>(T(8))) |
          (determinant(A) <= splat<R>(0))))
    return detail::with_far_stretches(A, f);
  return f(Stretches<R>(A, spectrum));
}
template <class R, class F>
NEVE_INLINE auto with_stretches(const Mat3<R>& A, F&& f) {
  return with_stretches(A, strain_of(A), f);
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
