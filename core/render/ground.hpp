// The set around the snow: how ground, solids and sky look in sun and haze.
#pragma once

#include "render/light.hpp"
#include "render/solids/surface_material.hpp"
#include "render/view/camera.hpp"

namespace neve::render {

struct Sky {
  Vec3f zenith, horizon;
  explicit Sky(const Light& light)
      : zenith(light.sky_color * Vec3f{0.30f, 0.50f, 0.82f}),
        horizon(light.sky_color * Vec3f{1.55f, 1.58f, 1.50f} + light.sun_color * 0.05f) {}

  Vec3f toward(Vec3f unit_direction, const Light& light) const {
    const float up = std::max(unit_direction.z, 0.0f);
    const float glow = std::pow(saturate(0.5f + 0.5f * dot(unit_direction, light.sun)), 6.0f);
    return mix(horizon, zenith, 1.0f - std::exp(-6.5f * up)) + light.sun_color * (0.06f * glow);
  }
};

// Share of the air's light over what is `far` away: none near the subject, all at the horizon.
inline float haze(float far, float reach) {
  const float beyond = far / reach - 1.25f;
  return beyond > 0 ? 1.0f - std::exp(-0.10f * beyond) : 0.0f;
}

inline Finish ground_finish(const Solid& solid, Vec3f point, Vec3f normal, float reach, float pixel) {
  Finish ground =
      frozen_ground(solid.local(point), transposed_times(solid.place.rotation, normal), reach, pixel);
  ground.normal = solid.place.rotation * ground.normal;
  return ground;
}

// Light from a point of the set: `sun` times the share of the sun that arrives, `sky` times that of the
// sky, `unshadowed`.
struct SetPoint {
  Vec3f sun{}, sky{}, unshadowed{};
};

inline SetPoint sky_point(const Sky& sky, const Light& light, Vec3f ray) {
  return {{}, {}, sky.toward(normalize(ray), light)};
}

// Light that a blurred mirror finds in this direction: the sky, or below the horizon the lit ground.
inline Vec3f surroundings(const Sky& sky, const Light& light, Vec3f unit_direction) {
  const Vec3f ground = (light.sun_color * std::max(light.sun.z, 0.0f) + light.sky_color) * 0.22f;
  return mix(ground, sky.toward(unit_direction, light), smoothstep(-0.25f, 0.15f, unit_direction.z));
}

// Describe the point of a solid that the ray from the eye meets first. All of it holds as long as solid,
// camera and light stay where they are.
inline SetPoint set_point(const Solid& solid, const Hit& hit, const Camera& camera, const Light& light,
                          const Sky& sky, Vec3f ray) {
  const Vec3f direction = normalize(ray), point = camera.eye + ray * hit.t;
  const float far = haze(length(ray) * hit.t, camera.reach);
  if (far > 0.995f) return sky_point(sky, light, ray);
  const float slant = std::max(std::abs(dot(hit.normal, direction)), 0.15f);
  const float pixel = hit.t / camera.focal / std::sqrt(slant);
  const Finish coat = solid.material == SurfaceMaterial::ground
                          ? ground_finish(solid, point, hit.normal, camera.reach, pixel)
                          : finish(solid, point, hit.normal, direction, pixel);
  const float lit = std::max(dot(coat.normal, light.sun), 0.0f) * saturate(8.0f * dot(hit.normal, light.sun));
  SetPoint set;
  set.sun = coat.color * light.sun_color * lit;
  if (coat.gleam > 0 && lit > 0) {
    const Vec3f half = normalize(light.sun - direction);
    const Vec3f tint = solid.material == SurfaceMaterial::metal ? coat.mirror : Vec3f{1, 1, 1};
    set.sun +=
        light.sun_color * tint * (coat.gleam * std::pow(saturate(dot(coat.normal, half)), coat.narrow));
  }
  set.sky = coat.color * light.sky_color;
  if (coat.mirror.x + coat.mirror.y + coat.mirror.z > 0)
    set.sky += coat.mirror *
               surroundings(sky, light, direction - coat.normal * (2.0f * dot(coat.normal, direction)));
  const float clear = 1.0f - far;
  set.sun = set.sun * clear, set.sky = set.sky * clear;
  set.unshadowed = coat.color * light.sun_color * (0.10f * (1.0f - std::abs(hit.normal.z)) * clear) +
                   sky.toward(normalize({direction.x, direction.y, 0.0f}), light) * far;
  return set;
}

// Share of the sun that the snow leaves to a point of the set.
inline float sun_arrival(const Density& snow, const Light& light, Vec3f point) {
  return snow.empty() ? 1.0f : std::exp(-sun_path(snow, point, light.sun, 0.3f, 0.0f).far);
}

// Share of the sky that the snow leaves to a point of the set.
inline float sky_arrival(const Density& snow, Vec3f point, Vec3f normal) {
  const float open =
      snow_around(snow, point) ? sky_light(snow, point, normal, 0.35f, 0.1f) : 0.5f + 0.5f * normal.z;
  // What hides the sky is snow for the most part, which shines as well.
  return mix(0.14f, open, saturate(open));
}

}  // namespace neve::render
