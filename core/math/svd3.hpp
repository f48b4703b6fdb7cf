// Polar singular value decomposition F = U diag(sigma) V^T of 3x3 matrices, a pack of them at once.
//
// U and V are rotations (det = +1); sigma_0 >= sigma_1 >= |sigma_2|, and an inverted F (det F < 0) carries its
// sign in sigma_2 (the convention of Irving et al. 2004). Method: cyclic Jacobi rotations diagonalise the strain
// E = F^T F - I; its columns of eigenvectors are V, and F V = U diag(sigma).
//
// Why E and not F^T F: near the identity the eigenvalues of E are the small numbers e = sigma^2 - 1, so the
// strain sigma - 1 = e / (sigma + 1) keeps its relative precision in float32.
//
// Convergence. Cyclic Jacobi is quadratic once the off-diagonal norm is below the eigenvalues' gap, and inside a
// cluster of equal eigenvalues any orthogonal basis serves. We sweep until every lane's squared off-diagonal norm
// is below eps^2 (4 ||E||^2 + 1), so the absolute error of sigma^2 is of the order of eps (1 + sigma_0^2) whatever F is
// (tests: random, inverted, rank one and two, large, near the identity). That is rounding for any F that snow can have;
// a matrix that is tiny as a whole, far below 1, keeps only that absolute precision.
#pragma once

#include "math/mat3.hpp"

namespace neve {

template <class R>
struct Svd3 {
  Mat3<R> U, V;
  Vec3<R> sigma;   // singular values
  Vec3<R> strain;  // sigma - 1, precise near zero
};

namespace detail {

// Rotate the plane of axes (p, q) so that the off-diagonal entry pq of the symmetric matrix (nearly) vanishes.
// rp, rq are the entries that couple p and q to the third axis; vp, vq the columns of V.
//
// tan 2a = pq / d with d = (pp - qq) / 2; of the two solutions the one with |a| <= pi/4 makes Jacobi converge:
// (cos a, sin a) ~ (|d| + sqrt(d^2 + pq^2), sign(d) pq). The root may be rough, since a small error of the angle only
// leaves a small rest for the next sweep; the normalisation is exact, so that V stays a rotation.
template <class R>
NEVE_INLINE void jacobi_rotate(R& pp, R& qq, R& pq, R& rp, R& rq, Vec3<R>& vp, Vec3<R>& vq) {
  using T = scalar_t<R>;
  constexpr T tiny = std::is_same_v<T, float> ? T(1e-30) : T(1e-280);
  const R d = (pp - qq) * T(0.5);
  const R r2 = max(d * d + pq * pq, splat<R>(tiny));
  const R h = abs(d) + r2 * rough_rsqrt(r2);
  const R b = select(d < splat<R>(0), -pq, pq);
  const R inv = rsqrt(h * h + b * b);
  const R c = h * inv, s = b * inv;
  const R p1 = c * pp + s * pq, p2 = c * pq + s * qq;
  const R q1 = c * pq - s * pp, q2 = c * qq - s * pq;
  pp = c * p1 + s * p2;
  qq = c * q2 - s * q1;
  pq = c * p2 - s * p1;
  const R rp2 = c * rp + s * rq;
  rq = c * rq - s * rp;
  rp = rp2;
  const Vec3<R> vp2 = vp * c + vq * s;
  vq = vq * c - vp * s;
  vp = vp2;
}

// Put the larger of two squared norms first; the turn keeps det V = +1.
template <class R>
NEVE_INLINE void order(R& a, R& b, Vec3<R>& va, Vec3<R>& vb) {
  const auto swap = a < b;
  const R a2 = max(a, b);
  b = min(a, b);
  a = a2;
  const Vec3<R> va2 = select(swap, vb, va);
  vb = select(swap, va * scalar_t<R>(-1), vb);
  va = va2;
}

template <class R>
NEVE_INLINE Vec3<R> normalised_or(const Vec3<R>& a, const Vec3<R>& otherwise) {
  using T = scalar_t<R>;
  const R n2 = dot(a, a);
  const auto good = n2 > splat<R>(std::numeric_limits<T>::min() * T(16));
  const R inv = T(1) / sqrt(select(good, n2, splat<R>(1)));
  return select(good, a * inv, otherwise);
}

// U and sigma from B = F V for any F: Gram-Schmidt on the columns, largest first.
template <class R>
NEVE_RARE void rotation_from_columns(const Mat3<R>& B, Svd3<R>& out) {
  using T = scalar_t<R>;
  const R o = splat<R>(1), z = splat<R>(0);
  const Vec3<R> u0 = normalised_or(B.c0, Vec3<R>{o, z, z});
  // any direction across u0, for a matrix of rank one
  const auto steep = abs(u0.x) > splat<R>(T(0.7));
  const Vec3<R> helper{select(steep, z, o), select(steep, o, z), z};
  const Vec3<R> across = normalised_or(cross(u0, helper), Vec3<R>{z, z, o});
  Vec3<R> b1 = B.c1 - u0 * dot(u0, B.c1);
  const R floor2 =
      T(1e-2) * std::numeric_limits<T>::epsilon() * std::numeric_limits<T>::epsilon() * dot(B.c0, B.c0);
  Vec3<R> u1 = select(dot(b1, b1) > floor2, normalised_or(b1, across), across);
  u1 = normalised_or(u1 - u0 * dot(u0, u1), across);
  out.U = {u0, u1, cross(u0, u1)};
  out.sigma = {dot(u0, B.c0), dot(u1, B.c1), dot(out.U.c2, B.c2)};
  out.strain = {out.sigma.x - T(1), out.sigma.y - T(1), out.sigma.z - T(1)};
}

// E = F^T F - I diagonalised: eigenvalues e and their frame V.
template <class R>
struct Strain3 {
  Vec3<R> e;
  Mat3<R> V;
};

template <class R>
NEVE_INLINE Strain3<R> diagonal_strain(const Mat3<R>& F) {
  using T = scalar_t<R>;
  R xx = dot(F.c0, F.c0) - T(1), yy = dot(F.c1, F.c1) - T(1), zz = dot(F.c2, F.c2) - T(1);
  R xy = dot(F.c0, F.c1), xz = dot(F.c0, F.c2), yz = dot(F.c1, F.c2);
  Mat3<R> V = identity<R>();
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const R size2 = xx * xx + yy * yy + zz * zz + T(2) * (xy * xy + xz * xz + yz * yz);
  const R enough = T(4) * eps * eps * size2 + splat<R>(eps * eps);
  for (int sweep = 0; sweep < 12; ++sweep) {
    if (!any(xy * xy + xz * xz + yz * yz > enough)) break;
    jacobi_rotate(xx, yy, xy, xz, yz, V.c0, V.c1);
    jacobi_rotate(yy, zz, yz, xy, xz, V.c1, V.c2);
    jacobi_rotate(xx, zz, xz, xy, yz, V.c0, V.c2);
  }
  return {{xx, yy, zz}, V};
}

}  // namespace detail

// Decompose F. Sifakis & Barbic 2012 (course notes) and McAdams et al. 2011 describe the family of methods.
template <class R>
NEVE_INLINE Svd3<R> svd3(const Mat3<R>& F) {
  using T = scalar_t<R>;
  detail::Strain3<R> strain = detail::diagonal_strain(F);
  Vec3<R>& e = strain.e;
  Svd3<R> out;
  const R lowest = min(min(e.x, e.y), e.z), highest = max(max(e.x, e.y), e.z);
  const bool far =
      any((lowest < splat<R>(T(-0.75))) | (determinant(F) <= splat<R>(0)) | (highest > splat<R>(8)));
  detail::order(e.x, e.y, strain.V.c0, strain.V.c1);
  detail::order(e.x, e.z, strain.V.c0, strain.V.c2);
  detail::order(e.y, e.z, strain.V.c1, strain.V.c2);
  out.V = strain.V;
  const Mat3<R> B = F * out.V;
  // Far from the identity (or inverted) the squared strain has lost digits: use the columns themselves.
  if (far) {
    detail::rotation_from_columns(B, out);
    return out;
  }
  for (int k = 0; k < 3; ++k) {
    const R square = e[k] + T(1), inverse = rsqrt(square);
    out.sigma[k] = square * inverse;
    out.strain[k] = e[k] / (out.sigma[k] + T(1));
    out.U.column(k) = B.column(k) * inverse;
  }
  return out;
}

}  // namespace neve
