// Single-precision vectors and the few operations that drawing needs.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "math/mat3.hpp"

namespace neve::render {

using Vec3f = Vec3<float>;
using Mat3f = Mat3<float>;

inline Vec3f operator-(Vec3f a) { return {-a.x, -a.y, -a.z}; }
inline Vec3f operator*(Vec3f a, Vec3f b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec3f operator*(float s, Vec3f a) { return a * s; }
inline Vec3f& operator+=(Vec3f& a, Vec3f b) { return a = a + b; }

inline float length(Vec3f a) { return std::sqrt(dot(a, a)); }
inline Vec3f normalize(Vec3f a) { return a * (1.0f / std::max(length(a), 1e-20f)); }
inline Vec3f mix(Vec3f a, Vec3f b, float t) { return a + (b - a) * t; }
inline float mix(float a, float b, float t) { return a + (b - a) * t; }
inline float saturate(float a) { return std::min(std::max(a, 0.0f), 1.0f); }
inline float smoothstep(float low, float high, float a) {
  const float t = saturate((a - low) / (high - low));
  return t * t * (3.0f - 2.0f * t);
}

// Return the whole number a, or the bound that it lies beyond; low for NaN.
template <class T>
int whole(T a, int low, int high) {
  return a > T(low) ? (a < T(high) ? int(a) : high) : low;
}

// Scramble 32 bits (the finaliser constants of the `lowbias32` hash by C. Wellons, public domain).
inline std::uint32_t scramble(std::uint32_t a) {
  a ^= a >> 16;
  a *= 0x7feb352du;
  a ^= a >> 15;
  a *= 0x846ca68bu;
  return a ^ (a >> 16);
}
// Turn 32 random bits into [0, 1).
inline float unit(std::uint32_t bits) { return float(bits >> 8) * (1.0f / 16777216.0f); }

}  // namespace neve::render
