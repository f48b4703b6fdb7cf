// The second derivative of an isotropic energy Psi(F) on the principal stretches sigma of F = U diag(sigma) V^T:
//
//   dP = U K V^T,   D = U^T dF V
//   K_ii = sum_j Psi_ij D_jj,   K_ij = 1/2 ((m + p) D_ij + (m - p) D_ji)
//   m = (Psi_i - Psi_j) / (sigma_i - sigma_j),   p = (Psi_i + Psi_j) / (sigma_i + sigma_j)
//
// So the nine directions fall apart into one block of three and three pairs, whose eigenvalues are m (stretch of the pair) and
// p (its rotation). Each elasticity gives m and p without the quotients, which would be 0/0 where stretches are equal. In
// compression p is negative, and the block may be indefinite: project() raises negative eigenvalues to zero, so that conjugate
// gradients and Newton's method go downhill. (Stomakhin et al. 2012, Smith et al. 2019, as quoted in public codes.)
#pragma once

#include "math/svd3.hpp"

namespace neve {

template <class R>
struct Tangent {
  Sym3<R> block;  // Psi_ij [Pa]
  Vec3<R> m, p;   // of the pair of axes beside k [Pa]
};

template <class R>
NEVE_INLINE Tangent<R> times(const Tangent<R>& t, const R& a) {
  return {times(t.block, a), t.m * a, t.p * a};
}
template <class R, class M>
NEVE_INLINE Tangent<R> select(const M& mask, const Tangent<R>& a, const Tangent<R>& b) {
  return {select(mask, a.block, b.block), select(mask, a.m, b.m), select(mask, a.p, b.p)};
}

// K from D.
template <class R>
NEVE_INLINE Mat3<R> contracted(const Tangent<R>& t, const Mat3<R>& D) {
  const R half = splat<R>(scalar_t<R>(0.5));
  const R xx = D.c0.x, yy = D.c1.y, zz = D.c2.z;
  const auto pair = [&](int k, const R& a, const R& b) {
    return half * (t.m[k] * (a + b) + t.p[k] * (a - b));
  };
  const R xy = D.c1.x, yx = D.c0.y, xz = D.c2.x, zx = D.c0.z, yz = D.c2.y, zy = D.c1.z;
  const Sym3<R>& b = t.block;
  return {{b.xx * xx + b.xy * yy + b.xz * zz, pair(2, yx, xy), pair(1, zx, xz)},
          {pair(2, xy, yx), b.xy * xx + b.yy * yy + b.yz * zz, pair(0, zy, yz)},
          {pair(1, xz, zx), pair(0, yz, zy), b.xz * xx + b.yz * yy + b.zz * zz}};
}

// Add the second derivative of U(J), J = sigma_1 sigma_2 sigma_3; `slope` U', `curvature` U''.
template <class R>
NEVE_INLINE void add_volume(Tangent<R>& t, const Vec3<R>& sigma, const R& slope, const R& curvature) {
  const Vec3<R> c{sigma.y * sigma.z, sigma.x * sigma.z, sigma.x * sigma.y}, turn = sigma * slope;
  Sym3<R>& b = t.block;
  b.xx += curvature * c.x * c.x, b.yy += curvature * c.y * c.y, b.zz += curvature * c.z * c.z;
  b.xy += curvature * c.x * c.y + turn.z;
  b.xz += curvature * c.x * c.z + turn.y;
  b.yz += curvature * c.y * c.z + turn.x;
  t.m = t.m - turn;
  t.p = t.p + turn;
}

namespace detail {

// The symmetric matrix with its negative eigenvalues raised to zero.
template <class R>
NEVE_RARE Sym3<R> positive_part(const Sym3<R>& s) {
  using T = scalar_t<R>;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  R xx = s.xx, yy = s.yy, zz = s.zz, xy = s.xy, xz = s.xz, yz = s.yz;
  Mat3<R> V = identity<R>();
  const R size2 = xx * xx + yy * yy + zz * zz + T(2) * (xy * xy + xz * xz + yz * yz);
  for (int sweep = 0; sweep < 12; ++sweep) {
    if (!any(xy * xy + xz * xz + yz * yz > size2 * (eps * eps))) break;
    jacobi_rotate(xx, yy, xy, xz, yz, V.c0, V.c1);
    jacobi_rotate(yy, zz, yz, xy, xz, V.c1, V.c2);
    jacobi_rotate(xx, zz, xz, xy, yz, V.c0, V.c2);
  }
  const R zero = splat<R>(0);
  const R e[3] = {max(xx, zero), max(yy, zero), max(zz, zero)};
  Sym3<R> out{};
  for (int k = 0; k < 3; ++k) {
    const Vec3<R>& v = V.column(k);
    const Vec3<R> w = v * e[k];
    out.xx += w.x * v.x, out.yy += w.y * v.y, out.zz += w.z * v.z;
    out.xy += w.x * v.y, out.xz += w.x * v.z, out.yz += w.y * v.z;
  }
  return out;
}

// Where a symmetric matrix has a negative eigenvalue: by its leading minors.
template <class R>
NEVE_INLINE auto is_indefinite(const Sym3<R>& s) {
  const R zero = splat<R>(0);
  const R second = s.xx * s.yy - s.xy * s.xy;
  const R third = s.xx * (s.yy * s.zz - s.yz * s.yz) - s.xy * (s.xy * s.zz - s.yz * s.xz) +
                  s.xz * (s.xy * s.yz - s.yy * s.xz);
  return (s.xx < zero) | (second < zero) | (third < zero);
}

}  // namespace detail

// The nearest tangent without negative eigenvalues; what is positive stays as it is, to the bit.
template <class R>
NEVE_INLINE Tangent<R> projected(const Tangent<R>& t) {
  const R zero = splat<R>(0);
  Tangent<R> out{t.block,
                 {max(t.m.x, zero), max(t.m.y, zero), max(t.m.z, zero)},
                 {max(t.p.x, zero), max(t.p.y, zero), max(t.p.z, zero)}};
  const auto odd = detail::is_indefinite(t.block);
  if (any(odd)) out.block = select(odd, detail::positive_part(t.block), t.block);
  return out;
}

}  // namespace neve
