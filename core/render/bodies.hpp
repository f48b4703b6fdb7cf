// Bodies as the picture needs them: where a ray meets them, what they hide of sun and sky.
#pragma once
#include <memory>
#include <span>

#include "render/mesh.hpp"

namespace neve::render {

enum class Shape { plane, box, sphere, cylinder, mesh };

/// What a surface is made of: frozen ground, or a body of some colour.
enum class Stuff { ground, paint, metal, rubber, wood, stone };

/// A body in its own frame: a plane is z = 0 with the snow at z > 0; a cylinder's axis is z.
struct Body {
  Shape shape;
  Vec3 position;
  Rotation turn;
  Vec3 half;   // half edges of a box; {radius, radius, half height} of a cylinder; {radius, ...} of a sphere
               // [m]
  Vec3 color;  // linear albedo
  Stuff stuff;
  bool rest;  // it stays where it is: what it shows and hides is kept from frame to frame
  std::shared_ptr<const Mesh> mesh;  // of the shape of that name
  Vec3 middle;                       // of a ball that holds the body
  float bound;                       // its radius [m]
  bool operator==(const Body&) const = default;
};

/// Put a body in its place. mesh: for the shape of that name only.
inline Body place(Shape shape, Vec3 position, const Rotation& turn, Vec3 half, Vec3 color, Stuff stuff,
                  bool rest, std::shared_ptr<const Mesh> mesh) {
  Body body{shape, position, turn, half, color, stuff, rest, std::move(mesh), position, 1e30f};
  switch (shape) {
    case Shape::plane: break;
    case Shape::box: body.bound = length(half); break;
    case Shape::sphere: body.bound = half.x; break;
    case Shape::cylinder: body.bound = std::hypot(half.x, half.z); break;
    case Shape::mesh:
      body.middle = position + turn.to_world(body.mesh->middle());
      body.bound = body.mesh->bound();
      break;
  }
  return body;
}

/// Turn a hit in the body's frame into one in the world.
inline Hit in_world(const Body& body, Hit hit) {
  hit.normal = body.turn.to_world(hit.normal);
  hit.lift = body.turn.to_world(hit.lift);
  return hit;
}

/// Meet the body from outside, or a mesh from either side. The direction need not have unit length.
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
    case Shape::mesh: hit = body.mesh->meet(p, d); break;
  }
  return in_world(body, hit);
}

/// Meet the nearest of these triangles of a mesh.
inline Hit meet_triangles(const Body& body, std::span<const uint32_t> triangles, Vec3 origin,
                          Vec3 direction) {
  return in_world(body, body.mesh->meet(triangles, body.turn.to_local(origin - body.position),
                                        body.turn.to_local(direction)));
}

/// Meet one triangle of a mesh, known to lie on the ray.
inline Hit meet_triangle(const Body& body, uint32_t triangle, Vec3 origin, Vec3 direction) {
  return in_world(body, body.mesh->meet(triangle, body.turn.to_local(origin - body.position),
                                        body.turn.to_local(direction)));
}

/// Signed distance from p to the body's surface [m], positive outside; of a mesh a rough one.
inline float distance(const Body& body, Vec3 point) {
  const Vec3 p = body.turn.to_local(point - body.position);
  switch (body.shape) {
    case Shape::plane: return p.z;
    case Shape::sphere: return length(p) - body.half.x;
    case Shape::box: return box_distance(body.half, p);
    case Shape::cylinder: return cylinder_distance(body.half.x, body.half.z, p);
    case Shape::mesh: break;
  }
  return body.mesh->distance(p);
}

constexpr float sun_angle = 0.05f;  // radius of the sun's (widened) disc [rad]

/// Share of the sun's disc seen from `point` past the body. A plane throws no shadow: it has no end, and
/// one wall would put the whole film in the dark. start: how far from the point a mesh begins to count [m].
inline float sun_past(const Body& body, Vec3 point, Vec3 sun, float start) {
  if (body.shape == Shape::plane) return 1.0f;
  const Vec3 to = body.middle - point;
  const float along = dot(to, sun);
  const float aside = std::sqrt(std::max(dot(to, to) - along * along, 0.0f));
  if (along < -body.bound || aside > body.bound * 1.1f + sun_angle * std::max(along, 0.0f)) return 1.0f;
  float seen = 1.0f, t = 0.02f * body.bound;  // seen: the nearest miss against the sun's disc
  if (body.shape == Shape::mesh) {
    seen = body.mesh->miss(body.turn.to_local(point - body.position), body.turn.to_local(sun), start,
                           sun_angle) /
           sun_angle;
  } else {
    for (int step = 0; step < 32 && t < along + body.bound && seen > 0.01f; ++step) {
      const float away = distance(body, point + sun * t);
      seen = std::min(seen, away / (sun_angle * t));
      t += std::max(away, 0.01f * body.bound);
    }
  }
  return smoothstep(0.0f, 1.0f, seen);
}

/// Share of the sky that is left where `away(t)` is the distance to what may hide it, t along the normal: distances
/// that come out shorter than the way walked mean something is close beside. reach: of the longest way [m].
template <class Away>
float open_sky(float reach, const Away& away) {
  float hidden = 0, weight = 0.55f;
  for (float step : {0.08f, 0.2f, 0.45f, 0.9f}) {
    const float t = step * reach;
    hidden += weight * saturate(1.0f - std::max(away(t), 0.0f) / t);
    weight *= 0.62f;
  }
  return 1.0f - 0.75f * saturate(hidden);
}

/// Share of the sky left by the body to a surface point with this normal.
inline float sky_past(const Body& body, Vec3 point, Vec3 normal) {
  if (body.shape == Shape::plane || length(point - body.middle) > 2.5f * body.bound) return 1.0f;
  const float reach = body.shape == Shape::mesh ? body.mesh->shade() : body.bound;
  return open_sky(reach, [&](float t) { return distance(body, point + normal * t); });
}

/// Share of the sky that a mesh leaves to a point of its own.
inline float sky_past_self(const Body& body, Vec3 point, Vec3 normal) {
  if (body.shape != Shape::mesh) return 1.0f;
  const Vec3 p = body.turn.to_local(point - body.position), n = body.turn.to_local(normal);
  return open_sky(body.mesh->shade(), [&](float t) { return body.mesh->nearest(p + n * t, t); });
}

}  // namespace neve::render
