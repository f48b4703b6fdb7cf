// The eigenvalues of the strain B = F F^T - I of 3x3 matrices, and isotropic functions of it, without its eigenvectors.
//
// With q = tr B / 3, p^2 = |B - q I|^2 / 6 and D = (B - q I) / p the eigenvalues of B are q + p d, and those of D are the
// roots of d^3 - 3 d = det D (Smith 1961). One, a = +-2 cos(theta / 3) with cos theta = |det D| / 2, stands apart: |a| >=
// sqrt 3. The others are -a/2 +- g/2. From the cubic, g^2 = 12 - 3 a^2, they would be known to the root of rounding where
// they meet. But P = (D - a)(D + a/2) is zero along the first and (g/2)(g/2 -+ 3/2 a) along the others, so that
// g^2 (9 a^2 + g^2) = 8 |P|^2, hence g^2 = 8 |P|^2 / (6 a^2 + 12), to rounding.
//
// A function that gives y_k for the eigenvalue d_k is the polynomial through these three points, taken of D. Nothing has
// to converge. As in svd3 the eigenvalues carry an absolute error of the order of eps (1 + sigma_0^2).
#pragma once

#include "math/mat3.hpp"

namespace neve {

// Of the three eigenvalues the first stands apart; the second is at least the third.
template <class R>
struct Spectrum3 {
  Vec3<R> e;      // eigenvalues of B
  R a, g;         // those of D: a, (g - a) / 2, (-g - a) / 2
  Sym3<R> D, D2;  // D and its square

  R lowest() const { return min(e.x, e.z); }
  R highest() const { return max(e.x, e.y); }
};

namespace detail {

// c_0 + c_1 t + c_2 t^2 + ...
template <class R>
NEVE_INLINE R polynomial(const R&, scalar_t<R> c) {
  return splat<R>(c);
}
template <class R, class... Rest>
NEVE_INLINE R polynomial(const R& t, scalar_t<R> c, Rest... rest) {
  return polynomial(t, rest...) * t + c;
}

// 2 cos(acos(r) / 3) for 0 <= r <= 1, interpolated at Chebyshev's points: to 4e-9 in float, 4e-18 in double.
template <class R>
NEVE_INLINE R root_apart(const R& r) {
  if constexpr (std::is_same_v<scalar_t<R>, float>) {
    return polynomial(r, 1.7320508112f, 0.33333274229f, -0.096208882906f, 0.049208593585f, -0.030214550322f,
                      0.018766661141f, -0.0098593823449f, 0.0035297137462f, -0.0006057084029f);
  } else {
    return polynomial(r, 1.732050807568877298, 0.333333333333329977, -0.09622504486448870764,
                      0.04938271602543389457, -0.03118404163815791244, 0.02194786196354340786,
                      -0.01651585455255546246, 0.01300500216432847276, -0.01057764930332364954,
                      0.008798778816302637678, -0.00739628519989653774, 0.006159020107513842319,
                      -0.004919776511726428124, 0.003608856270304925408, -0.002311537429704935835,
                      0.001224935447131682605, -0.0005057574009220451906, 0.0001505847630601450959,
                      -0.00002851333803504521817, 2.563778984443337394e-6);
  }
}

template <class R>
NEVE_INLINE Sym3<R> square(const Sym3<R>& a) {
  return {a.xx * a.xx + a.xy * a.xy + a.xz * a.xz, a.xy * a.xy + a.yy * a.yy + a.yz * a.yz,
          a.xz * a.xz + a.yz * a.yz + a.zz * a.zz, a.xx * a.xy + a.xy * a.yy + a.xz * a.yz,
          a.xx * a.xz + a.xy * a.yz + a.xz * a.zz, a.xy * a.xz + a.yy * a.yz + a.yz * a.zz};
}
template <class R>
NEVE_INLINE R norm2(const Sym3<R>& a) {
  return a.xx * a.xx + a.yy * a.yy + a.zz * a.zz + scalar_t<R>(2) * (a.xy * a.xy + a.xz * a.xz + a.yz * a.yz);
}
// c I + b B + a A
template <class R>
NEVE_INLINE Sym3<R> combined(const R& c, const R& b, const Sym3<R>& B, const R& a, const Sym3<R>& A) {
  return {c + b * B.xx + a * A.xx, c + b * B.yy + a * A.yy, c + b * B.zz + a * A.zz,
          b * B.xy + a * A.xy,     b * B.xz + a * A.xz,     b * B.yz + a * A.yz};
}

}  // namespace detail

// F F^T - I. The one is taken from the first square, which near the identity leaves a small number, exactly.
template <class R>
NEVE_INLINE Sym3<R> strain_of(const Mat3<R>& F) {
  using T = scalar_t<R>;
  const auto entry = [&](int i, int j) NEVE_INLINE_LAMBDA {
    return R(F.c0[i] * F.c0[j] + F.c1[i] * F.c1[j] + F.c2[i] * F.c2[j]);
  };
  const auto square = [](const R& one, const R& b, const R& c)
                          NEVE_INLINE_LAMBDA { return R((one * one - T(1)) + b * b + c * c); };
  return {square(F.c0.x, F.c1.x, F.c2.x),
          square(F.c1.y, F.c0.y, F.c2.y),
          square(F.c2.z, F.c0.z, F.c1.z),
          entry(0, 1),
          entry(0, 2),
          entry(1, 2)};
}

template <class R>
NEVE_INLINE Spectrum3<R> spectrum3(const Sym3<R>& B) {
  using T = scalar_t<R>;
  const R tiny = splat<R>(std::is_same_v<T, float> ? T(1e-30) : T(1e-280)), one = splat<R>(1);
  const R q = (B.xx + B.yy + B.zz) * T(1.0 / 3);
  const Sym3<R> pD{B.xx - q, B.yy - q, B.zz - q, B.xy, B.xz, B.yz};
  const R p2 = detail::norm2(pD) * T(1.0 / 6), per_p = rsqrt(max(p2, tiny)), p = p2 * per_p;

  Spectrum3<R> out;
  const Sym3<R> D{pD.xx * per_p, pD.yy * per_p, pD.zz * per_p, pD.xy * per_p, pD.xz * per_p, pD.yz * per_p};
  out.D = D;
  out.D2 = detail::square(D);
  const R det = D.xx * (D.yy * D.zz - D.yz * D.yz) + D.xy * (D.xz * D.yz - D.xy * D.zz) +
                D.xz * (D.xy * D.yz - D.yy * D.xz);
  const R size = detail::root_apart(min(abs(det) * T(0.5), one));
  out.a = select(det < splat<R>(0), -size, size);
  const R half = out.a * T(0.5);
  const R P2 = detail::norm2(detail::combined(R(half * out.a * T(-1)), R(-half), D, one, out.D2));
  out.g = P2 * rsqrt(max(P2, tiny)) * rsqrt(R(out.a * out.a * T(0.75) + T(1.5)));
  out.e = {q + p * out.a, q + p * (out.g * T(0.5) - half), q - p * (out.g * T(0.5) + half)};
  return out;
}

// sum_k y_k v_k v_k^T, v_k the eigenvectors of B in its order: mean + slope (D + a/2) + bend ((D + a/2)^2 - g^2/4).
template <class R>
NEVE_INLINE Sym3<R> isotropic_function(const Spectrum3<R>& of, const Vec3<R>& y) {
  using T = scalar_t<R>;
  const R least = splat<R>(std::is_same_v<T, float> ? T(1e-6) : T(1e-14));
  const R half = of.a * T(0.5), quarter = of.g * of.g * T(0.25), far = T(3) * half;
  const R mean = (y.y + y.z) * T(0.5), slope = (y.y - y.z) * reciprocal(max(of.g, least));
  const R bend = ((y.x - mean) - slope * far) * reciprocal(R(far * far - quarter));
  return detail::combined(R(mean + slope * half + bend * (half * half - quarter)), R(slope + bend * of.a),
                          of.D, bend, of.D2);
}

}  // namespace neve
