// Melt water that lies on a plane: it darkens the ground and, where it is deep enough to be a film, mirrors the sky.
#pragma once

#include "render/ground.hpp"

namespace neve::render {

// Wetness of a plane, from 0 (dry) to 1, at the middles of square cells in its own axes.
struct Puddle {
  int solid = -1;      // number of the plane
  float u = 0, v = 0;  // corner of the first cell [m]
  float cell = 1;      // side of a cell [m]
  int rows = 0, columns = 0;
  std::span<const float> wet;  // rows x columns

  // Linear between the middles of cells, 0 outside.
  float at(Vec3f local) const {
    const float a = (local.x - u) / cell - 0.5f, b = (local.y - v) / cell - 0.5f;
    if (!(a >= 0 && b >= 0 && a < float(rows - 1) && b < float(columns - 1))) return 0.0f;
    const int i = int(a), j = int(b);
    const float s = a - float(i), t = b - float(j);
    const auto value = [&](int r, int c) {
      return wet[std::size_t(r) * std::size_t(columns) + std::size_t(c)];
    };
    return mix(mix(value(i, j), value(i, j + 1), t), mix(value(i + 1, j), value(i + 1, j + 1), t), s);
  }
};

// Colour of wet ground over that of dry: our choice.
constexpr Vec3f wet_ground{0.42f, 0.41f, 0.42f};

// Light of ground that is wet. dry: its light; wet: 0 to 1; sun, sky: shares that arrive; direction: of the ray that sees
// it, of unit length; rough: height of the ground's crust there, from -1 to 1: hollows fill first.
inline Vec3f wet_light(Vec3f dry, float wet, float sun, float sky, Vec3f normal, Vec3f direction, float rough,
                       const Sky& above, const Light& light) {
  const float dark = saturate(1.7f * wet), film = smoothstep(0.35f, 0.75f, wet - 0.25f * rough);
  const float slant = 1.0f - saturate(-dot(normal, direction));
  const float mirror = 0.02f + 0.98f * slant * slant * slant * slant * slant;  // Schlick 1994, water in air
  const Vec3f toward = direction - normal * (2.0f * dot(normal, direction));
  const Vec3f half = normalize(light.sun - direction);
  const float glint = std::pow(saturate(dot(normal, half)), 220.0f);
  return dry * mix(Vec3f{1, 1, 1}, wet_ground, dark) * (1.0f - mirror * film) +
         above.toward(toward, light) * (mirror * film * sky) + light.sun_color * (1.5f * glint * film * sun);
}

// Light of a point of solid number `solid` that shines `dry`, with what puddles lie there. ray: from the eye; sun, sky:
// shares that arrive.
inline Vec3f with_water(Vec3f dry, std::span<const Puddle> puddles, int solid, const Solid& self,
                        const Camera& camera, Vec3f ray, float sun, float sky, const Sky& above,
                        const Light& light) {
  for (const Puddle& puddle : puddles) {
    if (puddle.solid != solid) continue;
    const Hit hit = meet(self, camera.eye, ray);
    if (hit.t > 1e20f) return dry;
    const Vec3f local = self.local(camera.eye + ray * hit.t);
    const float wet = saturate(puddle.at(local)), pixel = hit.t / camera.focal;
    if (wet <= 0) return dry;
    const float rough = fractal(local.x, local.y, 0.05f * camera.reach, 4, 0.6f, pixel, 907).value;
    const float far = haze(length(ray) * hit.t, camera.reach);
    return mix(wet_light(dry, wet, sun, sky, hit.normal, normalize(ray), rough, above, light), dry, far);
  }
  return dry;
}

}  // namespace neve::render
