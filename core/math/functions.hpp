// Functions of packs that arithmetic operators do not give: roots, floor, exponentials and logarithms. Each is written
// for one register; a pack of several goes through it register by register.
#pragma once

#include "math/compare.hpp"
#include "math/pack.hpp"

namespace neve {

namespace detail {

// f of each lane, as a loop over an array: the form that compilers turn into instructions on whole registers.
template <class P, class F>
NEVE_INLINE P each_lane(P a, F&& f) {
  alignas(sizeof(P)) scalar_t<P> v[width<P>];
  std::memcpy(v, &a, sizeof(P));
  for (scalar_t<P>& x : v) x = f(x);
  std::memcpy(&a, v, sizeof(P));
  return a;
}

// f of each register of a pack; of a scalar, the scalar.
template <class R, class F>
NEVE_INLINE R each_register(const R& a, F&& f) {
  return each_part<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA { return f(part_of(a, k)); });
}

// The integers of the same size, in as many lanes.
template <class P>
using Integers = Pack<std::conditional_t<sizeof(scalar_t<P>) == 4, std::int32_t, std::int64_t>, width<P>>;

template <class P>
NEVE_INLINE P sqrt_of_register(P a) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<P, Pack<float, 16>>) {
    return reinterpret_cast<P>(_mm512_sqrt_ps(reinterpret_cast<__m512>(a)));
  } else if constexpr (std::is_same_v<P, Pack<double, 8>>) {
    return reinterpret_cast<P>(_mm512_sqrt_pd(reinterpret_cast<__m512d>(a)));
  }
#elif defined(__aarch64__)
  if constexpr (std::is_same_v<P, Pack<float, 4>>) {
    return reinterpret_cast<P>(vsqrtq_f32(reinterpret_cast<float32x4_t>(a)));
  } else if constexpr (std::is_same_v<P, Pack<double, 2>>) {
    return reinterpret_cast<P>(vsqrtq_f64(reinterpret_cast<float64x2_t>(a)));
  }
#endif
  return each_lane(a, [](auto x) { return std::sqrt(x); });
}

template <class P>
NEVE_INLINE P floor_of_register(P a) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<P, Pack<float, 16>>) {
    return reinterpret_cast<P>(_mm512_floor_ps(reinterpret_cast<__m512>(a)));
  } else if constexpr (std::is_same_v<P, Pack<double, 8>>) {
    return reinterpret_cast<P>(_mm512_floor_pd(reinterpret_cast<__m512d>(a)));
  }
#elif defined(__aarch64__)
  if constexpr (std::is_same_v<P, Pack<float, 4>>) {
    return reinterpret_cast<P>(vrndmq_f32(reinterpret_cast<float32x4_t>(a)));
  } else if constexpr (std::is_same_v<P, Pack<double, 2>>) {
    return reinterpret_cast<P>(vrndmq_f64(reinterpret_cast<float64x2_t>(a)));
  }
#endif
  return each_lane(a, [](auto x) { return std::floor(x); });
}

template <class P>
NEVE_INLINE P rough_rsqrt_of_register(P a) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<P, Pack<float, 16>>) {
    return reinterpret_cast<P>(_mm512_rsqrt14_ps(reinterpret_cast<__m512>(a)));
  }
#endif
  return scalar_t<P>(1) / sqrt_of_register(a);
}

template <class P>
NEVE_INLINE P rsqrt_of_register(P a) {
  const P y = rough_rsqrt_of_register(a);
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<P, Pack<float, 16>>)
    return y * (1.5f - (0.5f * a) * y * y);  // Newton: 14 bits to 24
#endif
  return y;
}

template <class P>
NEVE_INLINE P reciprocal_of_register(P a) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<P, Pack<float, 16>>) {
    const P y = reinterpret_cast<P>(_mm512_rcp14_ps(reinterpret_cast<__m512>(a)));
    return y * (2.0f - a * y);  // Newton: 14 bits to 24
  }
#endif
  return scalar_t<P>(1) / a;
}

// exp(a) in float: a = n ln 2 + r, |r| <= ln 2 / 2, a polynomial of degree 6 in r, error < 2e-7.
template <class P>
NEVE_INLINE P exp_of_floats(P a) {
  a = clamp(a, splat<P>(-87.0f), splat<P>(88.0f));
  const P n = floor_of_register(a * 1.44269504f + 0.5f);
  const P r = (a - n * 0.693359375f) + n * 2.12194440e-4f;
  P p = splat<P>(1.0f / 720);
  for (float c : {1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f, 1.0f}) p = p * r + c;
  const Integers<P> bits = (__builtin_convertvector(n, Integers<P>) + 127) << 23;
  return p * reinterpret_cast<P>(bits);
}

// exp(a) in double: the same with degree 12, error < 2 eps; of what is not a number, as in float, the least value. ln 2 is a number of 32 bits, whose products with n are exact,
// and the rest; n + 1023 becomes whole in the last bits of a number so large that they count ones.
template <class P>
NEVE_INLINE P exp_of_doubles(P a) {
  a = clamp(a, splat<P>(-708.0), splat<P>(709.0));
  const P n = floor_of_register(a * 1.4426950408889634 + 0.5);
  const P r = (a - n * 0.693147180369123816490) - n * 1.90821492927058770002e-10;
  P p = splat<P>(1.0 / 479001600);
  for (double c : {1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320, 1.0 / 5040, 1.0 / 720, 1.0 / 120,
                   1.0 / 24, 1.0 / 6, 0.5, 1.0, 1.0})
    p = p * r + c;
  const Integers<P> bits = reinterpret_cast<Integers<P>>(n + (6755399441055744.0 + 1023)) << 52;
  return p * reinterpret_cast<P>(bits);
}

// exp(a) - 1 in float: a = n ln 2 + r as above, a polynomial of degree 7 for exp(r) - 1, and
// exp(a) - 1 = 2^n (exp(r) - 1) + (2^n - 1); error < 3 eps of the result.
template <class P>
NEVE_INLINE P expm1_of_floats(P a) {
  a = clamp(a, splat<P>(-87.0f), splat<P>(88.0f));
  const P n = floor_of_register(a * 1.44269504f + 0.5f);
  const P r = (a - n * 0.693359375f) + n * 2.12194440e-4f;
  P p = splat<P>(1.0f / 5040);
  for (float c : {1.0f / 720, 1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f}) p = p * r + c;
  const Integers<P> bits = (__builtin_convertvector(n, Integers<P>) + 127) << 23;
  const P power = reinterpret_cast<P>(bits);
  return power * (r + r * r * p) + (power - 1.0f);
}

// log(1 + a) in float: 1 + a = u + lost exactly, u = 2^n (1 + f) with 1 + f between 1/sqrt 2 and sqrt 2,
// log(1 + f) = 2 artanh(s) = 2 (s + s^3/3 + s^5/5 ...), s = f / (2 + f), where s^2 < 0.03 makes five terms enough; 2 s is
// written f - s f, so that f leads without rounding. Error < 3 eps.
template <class P>
NEVE_INLINE P log1p_of_floats(P a) {
  constexpr std::int32_t root_half = 0x3f3504f3;  // the bits of 1/sqrt 2
  const P u = a + 1.0f, most = u - 1.0f;
  const P lost = (1.0f - (u - most)) + (a - most);
  const Integers<P> bits = reinterpret_cast<Integers<P>>(u) - root_half;
  const P n = __builtin_convertvector(bits >> 23, P);
  const P f = reinterpret_cast<P>((bits & 0x7fffff) + root_half) - 1.0f;
  const P s = f / (f + 2.0f), z = s * s;
  P w = splat<P>(2.0f / 9);
  for (float c : {2.0f / 7, 2.0f / 5, 2.0f / 3}) w = w * z + c;
  return n * 0.693359375f + ((f - s * (f - w * z)) + (lost / u - n * 2.12194440e-4f));
}

}  // namespace detail

// Write whole numbers.
template <class R>
NEVE_INLINE void store_integers(std::int32_t* to, const R& a) {
  using P = part_t<R>;
  for_parts<register_count<R>>([&](int k) NEVE_INLINE_LAMBDA {
    const auto whole = __builtin_convertvector(part_of(a, k), Pack<std::int32_t, width<P>>);
    std::memcpy(to + k * width<P>, &whole, sizeof(whole));
  });
}

template <IsPack R>
NEVE_INLINE R sqrt(const R& a) {
  return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA { return detail::sqrt_of_register(p); });
}

template <IsPack R>
NEVE_INLINE R floor(const R& a) {
  return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA { return detail::floor_of_register(p); });
}

// Return 1/sqrt(a) for a > 0, to 14 bits or better.
template <IsPack R>
NEVE_INLINE R rough_rsqrt(const R& a) {
  return detail::each_register(a,
                               [](auto p) NEVE_INLINE_LAMBDA { return detail::rough_rsqrt_of_register(p); });
}

// Return 1/sqrt(a) for a > 0, within 2 ulp.
template <IsPack R>
NEVE_INLINE R rsqrt(const R& a) {
  return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA { return detail::rsqrt_of_register(p); });
}

// Return 1/a for finite a, within 2 ulp.
template <IsPack R>
NEVE_INLINE R reciprocal(const R& a) {
  return detail::each_register(a,
                               [](auto p) NEVE_INLINE_LAMBDA { return detail::reciprocal_of_register(p); });
}

// Return exp(a); in float lanes for -87 < a < 88, in double for -708 < a < 709, beyond which it stays what it is there.
template <IsPack R>
NEVE_INLINE R exp(const R& a) {
  if constexpr (std::is_same_v<scalar_t<R>, float>) {
    return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA { return detail::exp_of_floats(p); });
  } else {
    return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA { return detail::exp_of_doubles(p); });
  }
}

// Return exp(a) - 1, precise near zero.
template <IsPack R>
NEVE_INLINE R expm1(const R& a) {
  if constexpr (std::is_same_v<scalar_t<R>, float>) {
    return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA { return detail::expm1_of_floats(p); });
  } else {
    return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA {
      return detail::each_lane(p, [](double x) { return std::expm1(x); });
    });
  }
}

// Return log(1 + a) for a > -1, precise near zero.
template <IsPack R>
NEVE_INLINE R log1p(const R& a) {
  if constexpr (std::is_same_v<scalar_t<R>, float>) {
    return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA { return detail::log1p_of_floats(p); });
  } else {
    return detail::each_register(a, [](auto p) NEVE_INLINE_LAMBDA {
      return detail::each_lane(p, [](double x) { return std::log1p(x); });
    });
  }
}

}  // namespace neve
