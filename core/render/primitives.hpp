// Box, sphere and cylinder in their own frame: where a ray meets them, how far away they are.
#pragma once
#include "render/vec.hpp"

namespace neve::render {

struct Hit {
  float t = 1e30f;  // in lengths of the direction
  Vec3 normal;      // against the ray
  Vec3 lift{};      // from the point met to where a shadow ray may start [m]: off the triangles of a mesh
  bool operator==(const Hit&) const = default;
};

/// Meet the slab |p| <= half on one axis: narrow [near, far], remember the axis entered last.
inline void clip_slab(float p, float d, float half, int axis, float& near, float& far, int& entered) {
  const float inv = 1.0f / (std::abs(d) > 1e-12f ? d : std::copysign(1e-12f, d));
  const float a = (-half - p) * inv, b = (half - p) * inv;
  if (std::min(a, b) > near) {
    near = std::min(a, b);
    entered = axis;
  }
  far = std::min(far, std::max(a, b));
}

inline Vec3 axis_normal(int axis, Vec3 d) {
  return axis == 0   ? Vec3{d.x > 0 ? -1.0f : 1.0f, 0, 0}
         : axis == 1 ? Vec3{0, d.y > 0 ? -1.0f : 1.0f, 0}
                     : Vec3{0, 0, d.z > 0 ? -1.0f : 1.0f};
}

inline Hit meet_box(Vec3 half, Vec3 p, Vec3 d) {
  float near = 0, far = 1e30f;
  int axis = -1;
  clip_slab(p.x, d.x, half.x, 0, near, far, axis);
  clip_slab(p.y, d.y, half.y, 1, near, far, axis);
  clip_slab(p.z, d.z, half.z, 2, near, far, axis);
  if (axis < 0 || near >= far) return {};
  return {near, axis_normal(axis, d)};
}

inline Hit meet_sphere(float radius, Vec3 p, Vec3 d) {
  const float a = dot(d, d), b = dot(p, d), c = dot(p, p) - radius * radius;
  const float root = b * b - a * c;
  if (root <= 0) return {};
  const float t = (-b - std::sqrt(root)) / a;
  if (t <= 0) return {};
  return {t, normalize(p + d * t)};
}

inline Hit meet_cylinder(float radius, float half_height, Vec3 p, Vec3 d) {
  float near = 0, far = 1e30f;
  int axis = -1;
  clip_slab(p.z, d.z, half_height, 2, near, far, axis);
  const float a = d.x * d.x + d.y * d.y, b = p.x * d.x + p.y * d.y,
              c = p.x * p.x + p.y * p.y - radius * radius;
  const float root = b * b - a * c;
  if (a < 1e-12f ? c > 0 : root <= 0) return {};
  if (a >= 1e-12f) {
    const float from = (-b - std::sqrt(root)) / a;
    far = std::min(far, (-b + std::sqrt(root)) / a);
    if (from > near) {
      near = from;
      axis = 0;
    }
  }
  if (axis < 0 || near >= far) return {};
  const Vec3 q = p + d * near;
  return {near, axis == 2 ? axis_normal(2, d) : normalize({q.x, q.y, 0})};
}

/// Signed distance to a box [m], positive outside.
inline float box_distance(Vec3 half, Vec3 p) {
  const Vec3 d{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
  const Vec3 outside{std::max(d.x, 0.0f), std::max(d.y, 0.0f), std::max(d.z, 0.0f)};
  return length(outside) + std::min(std::max({d.x, d.y, d.z}), 0.0f);
}

/// Signed distance to a cylinder around z [m], positive outside.
inline float cylinder_distance(float radius, float half_height, Vec3 p) {
  const float aside = std::sqrt(p.x * p.x + p.y * p.y) - radius, up = std::abs(p.z) - half_height;
  if (aside > 0 && up > 0) return std::sqrt(aside * aside + up * up);
  return std::max(aside, up);
}

}  // namespace neve::render
