// Three floats and the few operations that drawing needs.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace neve::render {

struct Vec3 {
  float x = 0, y = 0, z = 0;
  bool operator==(const Vec3&) const = default;
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3 operator*(float s, Vec3 a) { return a * s; }
inline Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }

inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3 normalize(Vec3 a) { return a * (1.0f / std::max(length(a), 1e-20f)); }
inline Vec3 mix(Vec3 a, Vec3 b, float t) { return a + (b - a) * t; }
inline float mix(float a, float b, float t) { return a + (b - a) * t; }
inline float saturate(float a) { return std::min(std::max(a, 0.0f), 1.0f); }
inline float smoothstep(float low, float high, float a) {
  const float t = saturate((a - low) / (high - low));
  return t * t * (3.0f - 2.0f * t);
}
inline bool finite(Vec3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

/// A rotation as its three columns: world = col(0) a.x + col(1) a.y + col(2) a.z.
struct Rotation {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  bool operator==(const Rotation&) const = default;
  Vec3 to_world(Vec3 a) const { return x * a.x + y * a.y + z * a.z; }
  Vec3 to_local(Vec3 a) const { return {dot(x, a), dot(y, a), dot(z, a)}; }
};

/// Scramble 32 bits (the finaliser constants of the `lowbias32` hash by C. Wellons, public domain).
inline uint32_t scramble(uint32_t a) {
  a ^= a >> 16;
  a *= 0x7feb352du;
  a ^= a >> 15;
  a *= 0x846ca68bu;
  return a ^ (a >> 16);
}
/// Turn 32 random bits into [0, 1).
inline float unit(uint32_t bits) { return float(bits >> 8) * (1.0f / 16777216.0f); }

}  // namespace neve::render
