// Solids as the picture needs them: where a ray meets them, what they hide of sun and sky.
#pragma once

#include <memory>
#include <span>

#include "geometry/shape_rays.hpp"
#include "render/solids/mesh.hpp"

namespace neve::render {

// What a surface is made of: frozen ground, or a solid of some colour.
enum class SurfaceMaterial { ground, paint, metal, rubber, wood, stone };
inline constexpr const char* surface_material_names[] = {"ground", "paint", "metal",
                                                         "rubber", "wood",  "stone"};

struct Solid {
  PlacedShape<float> place;
  Vec3f color{};  // linear albedo
  SurfaceMaterial material;
  bool is_static;  // it stays where it is: what it shows and hides is kept from frame to frame
  std::shared_ptr<const Mesh> mesh;  // the triangles of a shape with samples
  Vec3f middle{};                    // of a ball that holds the solid
  float bound;                       // its radius [m]
  bool operator==(const Solid&) const = default;

  Vec3f local(Vec3f point) const { return transposed_times(place.rotation, point - place.centre); }
  bool is_plane() const { return !mesh && !is_bounded(place.kind); }
};

// Describe a solid in its place. mesh: the triangles of a shape with samples.
inline Solid make_solid(const PlacedShape<float>& place, Vec3f color, SurfaceMaterial material,
                        bool is_static, std::shared_ptr<const Mesh> mesh) {
  Solid solid{place, color, material, is_static, std::move(mesh), place.centre, 1e30f};
  if (solid.mesh) {
    solid.middle = place.centre + place.rotation * solid.mesh->middle();
    solid.bound = solid.mesh->bound();
  } else if (is_bounded(place.kind)) {
    solid.bound = bounding_radius(place.kind, place.half);
  }
  return solid;
}

// Turn a hit in the solid's frame into one in the world.
inline Hit in_world(const Solid& solid, Hit hit) {
  hit.normal = solid.place.rotation * hit.normal;
  hit.lift = solid.place.rotation * hit.lift;
  return hit;
}

// Meet the solid from outside, or a mesh from either side. The direction need not have unit length.
inline Hit meet(const Solid& solid, Vec3f origin, Vec3f direction) {
  const Vec3f p = solid.local(origin), d = transposed_times(solid.place.rotation, direction);
  if (solid.mesh) return in_world(solid, solid.mesh->meet(p, d));
  const ShapeHit<float> hit = enter(solid.place.kind, solid.place.half, p, d);
  return in_world(solid, {hit.t, hit.normal});
}

// Meet the nearest of these triangles of a mesh.
inline Hit meet_triangles(const Solid& solid, std::span<const std::uint32_t> triangles, Vec3f origin,
                          Vec3f direction) {
  return in_world(solid, solid.mesh->meet(triangles, solid.local(origin),
                                          transposed_times(solid.place.rotation, direction)));
}

// Meet one triangle of a mesh, known to lie on the ray.
inline Hit meet_triangle(const Solid& solid, std::uint32_t triangle, Vec3f origin, Vec3f direction) {
  return in_world(solid, solid.mesh->meet(triangle, solid.local(origin),
                                          transposed_times(solid.place.rotation, direction)));
}

// Signed distance from a point to the solid's surface [m], positive outside; of a mesh a rough one.
inline float distance(const Solid& solid, Vec3f point) {
  return solid.mesh ? solid.mesh->distance(solid.local(point)) : surface(solid.place, point).phi;
}

constexpr float sun_angle = 0.05f;  // radius of the sun's (widened) disc [rad]

// Share of the sun's disc seen from `point` past the solid. A plane throws no shadow: it has no end, and
// one wall would put the whole film in the dark. start: how far from the point a mesh begins to count [m].
inline float sun_past(const Solid& solid, Vec3f point, Vec3f sun, float start) {
  if (solid.is_plane()) return 1.0f;
  const Vec3f to = solid.middle - point;
  const float along = dot(to, sun);
  const float aside = std::sqrt(std::max(dot(to, to) - along * along, 0.0f));
  if (along < -solid.bound || aside > solid.bound * 1.1f + sun_angle * std::max(along, 0.0f)) return 1.0f;
  float seen = 1.0f, t = 0.02f * solid.bound;  // seen: the nearest miss against the sun's disc
  if (solid.mesh) {
    seen =
        solid.mesh->miss(solid.local(point), transposed_times(solid.place.rotation, sun), start, sun_angle) /
        sun_angle;
  } else {
    for (int step = 0; step < 32 && t < along + solid.bound && seen > 0.01f; ++step) {
      const float away = distance(solid, point + sun * t);
      seen = std::min(seen, away / (sun_angle * t));
      t += std::max(away, 0.01f * solid.bound);
    }
  }
  return smoothstep(0.0f, 1.0f, seen);
}

// Share of the sky that is left where `away(t)` is the distance to what may hide it, t along the normal: distances
// that come out shorter than the way walked mean something is close beside. reach: of the longest way [m].
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

// Share of the sky left by the solid to a surface point with this normal.
inline float sky_past(const Solid& solid, Vec3f point, Vec3f normal) {
  if (solid.is_plane() || length(point - solid.middle) > 2.5f * solid.bound) return 1.0f;
  const float reach = solid.mesh ? solid.mesh->shade() : solid.bound;
  return open_sky(reach, [&](float t) { return distance(solid, point + normal * t); });
}

// Share of the sky that a mesh leaves to a point of its own.
inline float sky_past_self(const Solid& solid, Vec3f point, Vec3f normal) {
  if (!solid.mesh) return 1.0f;
  const Vec3f p = solid.local(point), n = transposed_times(solid.place.rotation, normal);
  return open_sky(solid.mesh->shade(), [&](float t) { return solid.mesh->nearest(p + n * t, t); });
}

}  // namespace neve::render
