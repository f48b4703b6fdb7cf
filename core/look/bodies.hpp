// Colliders as the picture needs them: where a ray meets them, how far away they are.
#pragma once
#include <span>

#include "look/vec.hpp"

namespace neve::look {

enum class Shape { plane, box, sphere, cylinder };

/// A body in its own frame: a plane is z = 0 with the snow at z > 0; a cylinder's axis is z.
struct Body {
  Shape shape;
  Vec3 position;
  Rotation turn;
  Vec3 half;   // half edges of a box; {radius, radius, half height} of a cylinder; {radius, ...} of a sphere
               // [m]
  Vec3 color;  // linear albedo
  bool natural;  // frozen ground instead of paint
  float bound;   // radius of a ball that holds the body [m]
  bool operator==(const Body&) const = default;
};

struct Hit {
  float t = 1e30f;  // in lengths of the direction
  Vec3 normal;
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

/// Meet the body from outside. The direction need not have unit length.
inline Hit meet(const Body& body, Vec3 origin, Vec3 direction) {
  const Vec3 p = body.turn.to_local(origin - body.position), d = body.turn.to_local(direction);
  Hit hit;
  switch (body.shape) {
    case Shape::plane:
      if (p.z > 0 && d.z < 0) hit = {-p.z / d.z, {0, 0, 1}};
      break;
    case Shape::box: hit = meet_box(body.half, p, d); break;
    case Shape::sphere: hit = meet_sphere(body.half.x, p, d); break;
    case Shape::cylinder: hit = meet_cylinder(body.half.x, body.half.z, p, d); break;
  }
  hit.normal = body.turn.to_world(hit.normal);
  return hit;
}

/// Signed distance from p to the body's surface [m], positive outside.
inline float distance(const Body& body, Vec3 point) {
  const Vec3 p = body.turn.to_local(point - body.position);
  float a, b, c;
  switch (body.shape) {
    case Shape::plane: return p.z;
    case Shape::sphere: return length(p) - body.half.x;
    case Shape::box:
      a = std::abs(p.x) - body.half.x, b = std::abs(p.y) - body.half.y, c = std::abs(p.z) - body.half.z;
      break;
    default:
      a = std::sqrt(p.x * p.x + p.y * p.y) - body.half.x, b = a, c = std::abs(p.z) - body.half.z;
      if (a > 0 && c > 0) return std::sqrt(a * a + c * c);
      return std::max(a, c);
  }
  const Vec3 outside{std::max(a, 0.0f), std::max(b, 0.0f), std::max(c, 0.0f)};
  return length(outside) + std::min(std::max({a, b, c}), 0.0f);
}

/// Share of the sun's disc seen from `point` past the body. A plane throws no shadow: it has no end, and
/// one wall would put the whole film in the dark.
inline float sun_past(const Body& body, Vec3 point, Vec3 sun) {
  if (body.shape == Shape::plane) return 1.0f;
  const Vec3 to = body.position - point;
  const float along = dot(to, sun);
  const float aside = std::sqrt(std::max(dot(to, to) - along * along, 0.0f));
  if (along < -body.bound || aside > body.bound * 1.1f + 0.05f * std::max(along, 0.0f)) return 1.0f;
  float seen = 1.0f, t = 0.02f * body.bound;
  for (int step = 0; step < 32 && t < along + body.bound && seen > 0.01f; ++step) {
    const float away = distance(body, point + sun * t);
    seen = std::min(seen, 20.0f * away / t);  // the nearest miss against the sun's (widened) disc
    t += std::max(away, 0.01f * body.bound);
  }
  return smoothstep(0.0f, 1.0f, seen);
}

/// Share of the sky left by the body to a surface point with this normal: distances along the normal that
/// come out shorter than the way walked mean something is close beside.
inline float sky_past(const Body& body, Vec3 point, Vec3 normal) {
  if (body.shape == Shape::plane || length(point - body.position) > 2.5f * body.bound) return 1.0f;
  float hidden = 0, weight = 0.55f;
  for (float step : {0.08f, 0.2f, 0.45f, 0.9f}) {
    const float t = step * body.bound;
    hidden += weight * saturate(1.0f - std::max(distance(body, point + normal * t), 0.0f) / t);
    weight *= 0.62f;
  }
  return 1.0f - 0.75f * saturate(hidden);
}

}  // namespace neve::look
