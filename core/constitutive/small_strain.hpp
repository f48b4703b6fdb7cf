// Small strains B = F F^T - I: bounds of their eigenvalues, and functions of them, from the invariants alone.
//
// The eigenvalues b_k of B all lie between two numbers if those of B - low I and of high I - B are positive, and real
// numbers are all positive if and only if their elementary symmetric functions are (Descartes' rule of signs). Of B
// these are I_1 = sum b_k, I_2 = sum b_j b_k and I_3 = b_1 b_2 b_3, and those of B less a number follow from them.
//
// A power series of B is c_0 + c_1 B + c_2 B^2 by B^3 = I_1 B^2 - I_2 B + I_3 (Cayley and Hamilton).
#pragma once

#include "constitutive/law.hpp"
#include "constitutive/spectrum3.hpp"

namespace neve {

// Eigenvalues of B up to this size are small: series of them end after few terms.
inline constexpr double small_strain = 0.0625;

// The coefficients, from that of the first power on, of 1 + b - sqrt(1 + b): as many as rounding sees where b is small.
template <class T>
struct LessRoot {
  static constexpr int count = std::is_same_v<T, float> ? 5 : 12;
  T of[count];

  constexpr LessRoot() : of{} {
    double c = 0.5;  // of the root
    of[0] = T(0.5);
    for (int k = 1; k < count; ++k) {
      c *= (0.5 - k) / (k + 1);
      of[k] = T(-c);
    }
  }
};

template <class R>
struct SmallStrain {
  using T = scalar_t<R>;
  Sym3<R> B, B2;
  R first, second, third;  // invariants of B

  NEVE_INLINE explicit SmallStrain(const Sym3<R>& its) : B(its), B2(detail::square(its)) {
    const R yz = B.yy * B.zz - B.yz * B.yz;
    first = B.xx + B.yy + B.zz;
    second = yz + B.xx * (B.yy + B.zz) - B.xy * B.xy - B.xz * B.xz;
    third = B.xx * yz + B.xy * (B.xz * B.yz - B.xy * B.zz) + B.xz * (B.xy * B.yz - B.yy * B.xz);
  }

  // Whether all eigenvalues lie between `low` and `high`.
  NEVE_INLINE auto lies_between(const R& low, const R& high) const {
    const R zero = splat<R>(0);
    return (first > low * T(3)) & (less_second(low) > zero) & (less_third(low) > zero) &
           (first < high * T(3)) & (less_second(high) > zero) & (less_third(high) < zero);
  }

  // det(I + B) = J^2, less 1.
  NEVE_INLINE R square_volume_change() const { return first + (second + third); }

  // The largest eigenvalue, by Smith's formula (spectrum3.hpp): where all nearly meet, to the third root of rounding
  // times their size.
  NEVE_INLINE R largest() const {
    const R tiny = splat<R>(std::is_same_v<T, float> ? T(1e-30) : T(1e-280)), one = splat<R>(1);
    const R q = first * T(1.0 / 3), p2 = max(R(q * q - second * T(1.0 / 3)), tiny), per_p = rsqrt(p2);
    const R det = (third + q * (T(2) * q * q - second)) * (per_p * per_p) * per_p;
    const R a = detail::root_apart(min(abs(det) * T(0.5), one));
    const R other = (a + sqrt(max(R(T(12) - T(3) * a * a), splat<R>(0)))) * T(0.5);
    return q + p2 * per_p * select(det < splat<R>(0), other, a);
  }

  // The symmetric matrix I + B - sqrt(I + B) = V^2 - V, V the left stretch.
  NEVE_INLINE Sym3<R> less_root() const {
    constexpr LessRoot<T> c;
    constexpr int last = c.count - 1;
    R one = splat<R>(c.of[last - 2]), linear = splat<R>(c.of[last - 1]), square = splat<R>(c.of[last]);
    NEVE_UNROLL
    for (int k = last - 3; k >= -1; --k) {
      const R next = one - square * second, before = linear + square * first;
      one = square * third + (k >= 0 ? c.of[k] : T(0));
      linear = next, square = before;
    }
    return detail::combined(one, linear, B, square, B2);
  }

 private:
  // The second and third symmetric function of the eigenvalues less x.
  NEVE_INLINE R less_second(const R& x) const { return second - x * (first * T(2) - x * T(3)); }
  NEVE_INLINE R less_third(const R& x) const { return third - x * (second - x * (first - x)); }
};

}  // namespace neve
