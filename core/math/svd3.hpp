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
// is below eps^2 (4 ||E||^2 + 1), so the residual of sigma^2 is of the order of rounding whatever F is (tests: random,
// inverted, rank one and two, 1e-9..1e9 scaled, near the identity). Snow in its elastic range needs two sweeps.
#pragma once

#include <limits>

#include "math/mat3.hpp"

namespace neve {

template <class R>
struct Svd3 {
  Mat3<R> U, V;
  Vec3<R> sigma;   // singular values
  Vec3<R> strain;  // sigma - 1, precise near zero
};

namespace detail {

// Rotate the plane of axes (p, q) so that the off-diagonal entry pq of the symmetric matrix vanishes.
// rp, rq are the entries that couple p and q to the third axis; vp, vq the columns of V.
template <class R>
inline void jacobi_rotate(R& pp, R& qq, R& pq, R& rp, R& rq, Vec3<R>& vp, Vec3<R>& vq) {
  using T = scalar_t<R>;
  constexpr T tiny = std::numeric_limits<T>::min() * T(16);
  const R d = (pp - qq) * T(0.5);
  const R r2 = d * d + pq * pq;
  const auto flat = r2 < tiny;  // already diagonal and equal: nothing to turn
  const R r = rsqrt(max(r2, splat<R>(tiny)));
  // cos 2a = |d| / sqrt(d^2 + pq^2), so that |a| <= pi/4, the small angle that makes Jacobi converge
  const R c2 = select(flat, splat<R>(1), T(0.5) + T(0.5) * min(abs(d) * r, splat<R>(1)));
  const R inv_c = rsqrt(c2);
  const R c = c2 * inv_c;
  const R sign = select(d < T(0), splat<R>(-1), splat<R>(1));
  const R s = select(flat, splat<R>(0), T(0.5) * sign * pq * r * inv_c);
  const R cc = c * c, ss = s * s, cs2 = T(2) * c * s * pq;
  const R p2 = cc * pp + cs2 + ss * qq;
  const R q2 = ss * pp - cs2 + cc * qq;
  pq = (cc - ss) * pq - c * s * (pp - qq);
  pp = p2;
  qq = q2;
  const R rp2 = c * rp + s * rq;
  rq = c * rq - s * rp;
  rp = rp2;
  const Vec3<R> vp2 = vp * c + vq * s;
  vq = vq * c - vp * s;
  vp = vp2;
}

// Put the larger of two squared norms first; the turn keeps det V = +1.
template <class R>
inline void order(R& a, R& b, Vec3<R>& va, Vec3<R>& vb) {
  const auto swap = a < b;
  const R a2 = max(a, b);
  b = min(a, b);
  a = a2;
  const Vec3<R> va2 = select(swap, vb, va);
  vb = select(swap, va * scalar_t<R>(-1), vb);
  va = va2;
}

template <class R>
inline Vec3<R> normalised_or(const Vec3<R>& a, const Vec3<R>& otherwise) {
  using T = scalar_t<R>;
  const R n2 = dot(a, a);
  const auto good = n2 > std::numeric_limits<T>::min() * T(16);
  const R inv = T(1) / sqrt(select(good, n2, splat<R>(1)));
  return select(good, a * inv, otherwise);
}

// U and sigma from B = F V for any F: Gram-Schmidt on the columns, largest first.
template <class R>
inline void rotation_from_columns(const Mat3<R>& B, Svd3<R>& out) {
  using T = scalar_t<R>;
  const R o = splat<R>(1), z = splat<R>(0);
  const Vec3<R> u0 = normalised_or(B.c0, Vec3<R>{o, z, z});
  // any direction across u0, for a matrix of rank one
  const auto steep = abs(u0.x) > T(0.7);
  const Vec3<R> helper{select(steep, z, o), select(steep, o, z), z};
  const Vec3<R> across = normalised_or(cross(u0, helper), Vec3<R>{z, z, o});
  Vec3<R> b1 = B.c1 - u0 * dot(u0, B.c1);
  const R floor2 = T(1e-2) * std::numeric_limits<T>::epsilon() * std::numeric_limits<T>::epsilon() * dot(B.c0, B.c0);
  Vec3<R> u1 = select(dot(b1, b1) > floor2, normalised_or(b1, across), across);
  u1 = normalised_or(u1 - u0 * dot(u0, u1), across);
  out.U = {u0, u1, cross(u0, u1)};
  out.sigma = {dot(u0, B.c0), dot(u1, B.c1), dot(out.U.c2, B.c2)};
  out.strain = {out.sigma.x - T(1), out.sigma.y - T(1), out.sigma.z - T(1)};
}

}  // namespace detail

// Decompose F. Sifakis & Barbic 2012 (course notes) and McAdams et al. 2011 describe the family of methods.
template <class R>
inline Svd3<R> svd3(const Mat3<R>& F) {
  using T = scalar_t<R>;
  R xx = dot(F.c0, F.c0) - T(1), yy = dot(F.c1, F.c1) - T(1), zz = dot(F.c2, F.c2) - T(1);
  R xy = dot(F.c0, F.c1), xz = dot(F.c0, F.c2), yz = dot(F.c1, F.c2);
  Svd3<R> out;
  out.V = identity<R>();
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const R size2 = xx * xx + yy * yy + zz * zz + T(2) * (xy * xy + xz * xz + yz * yz);
  const R enough = T(4) * eps * eps * size2 + eps * eps;
  for (int sweep = 0; sweep < 12; ++sweep) {
    if (!any(xy * xy + xz * xz + yz * yz > enough)) break;
    detail::jacobi_rotate(xx, yy, xy, xz, yz, out.V.c0, out.V.c1);
    detail::jacobi_rotate(yy, zz, yz, xy, xz, out.V.c1, out.V.c2);
    detail::jacobi_rotate(xx, zz, xz, xy, yz, out.V.c0, out.V.c2);
  }
  detail::order(xx, yy, out.V.c0, out.V.c1);
  detail::order(xx, zz, out.V.c0, out.V.c2);
  detail::order(yy, zz, out.V.c1, out.V.c2);
  const Mat3<R> B = F * out.V;
  const R J = determinant(F);
  // Far from the identity (or inverted) the squared strain has lost digits: use the columns themselves.
  if (any((zz < T(-0.75)) | (J <= T(0)) | (xx > T(8)))) {
    detail::rotation_from_columns(B, out);
    return out;
  }
  const Vec3<R> e{xx, yy, zz};
  for (int k = 0; k < 3; ++k) {
    out.sigma[k] = sqrt(T(1) + e[k]);
    out.strain[k] = e[k] / (T(1) + out.sigma[k]);
    out.U.column(k) = B.column(k) * (T(1) / out.sigma[k]);
  }
  return out;
}

}  // namespace neve
