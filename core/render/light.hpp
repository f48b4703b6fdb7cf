// Sun and sky through the snow: how much of each arrives at a point.
#pragma once

#include "render/density.hpp"
#include "render/solids/solid_set.hpp"

namespace neve::render {

struct Light {
  Vec3f sun{};        // unit vector towards the sun
  Vec3f sun_color{};  // irradiance on a surface that faces the sun
  Vec3f sky_color{};  // irradiance of the whole sky on level ground
};

// Optical depth of one cell of solid snow. Grains at half a cell's distance and with as large a radius
// cross a beam 1.6 times per cell (n pi r^2); we take a little less, so that edges glow.
constexpr float cell_depth = 1.2f;

// What the snow between a point and the sun does to its light.
struct SunPath {
  float near = 0;  // optical depth of the first cells: the surface's own snow
  float far = 0;   // optical depth of all that follows
};

// Walk from p towards the sun until the snow ends or nothing is left of the light.
// start, near: where the walk begins and where the snow stops being the point's own [cells].
inline SunPath sun_path(const Density& snow, Vec3f p, Vec3f sun, float start, float near) {
  constexpr int step_limit = 160;
  constexpr float dark = 8.0f;
  const float h = snow.cell_size();
  const Blocks &middle = snow.level(2), &all = snow.level(Density::levels - 1);
  float t = start * h, end = 1e30f, inside = 0;  // inside: where the occupied block around t ends
  SunPath path;
  all.clip(p, sun, t, end);
  for (int step = 0; step < step_limit && t < end && path.near + path.far < dark; ++step) {
    if (t >= inside) {
      const Vec3f q = p + sun * t;
      const bool occupied = middle.occupied(q);
      inside = t + (occupied || all.occupied(q) ? middle : all).exit(q, sun) + 0.01f * h;
      if (!occupied) {
        t = inside;
        continue;
      }
    }
    const float width = std::max(1.0f, 0.1f * t / h);  // of the penumbra and the step, in cells
    const Vec3f between = p + sun * (t + 0.5f * width * h);
    const float fraction = width > 1 ? snow.sample_between(between, std::log2(width)) : snow.sample(between);
    (t < near * h ? path.near : path.far) += cell_depth * width * fraction;
    t += width * h;
  }
  return path;
}

// Directions in which the sky is asked: one up, five around at 40 degrees. Fixed in the world, so that the
// answers do not shimmer.
struct SkyCone {
  Vec3f direction{};
  float weight;  // share of the sky's light
};
constexpr SkyCone sky_cones[6] = {{{0.0f, 0.0f, 1.0f}, 0.30f},
                                  {{0.7660f, 0.0000f, 0.6428f}, 0.14f},
                                  {{0.2367f, 0.7285f, 0.6428f}, 0.14f},
                                  {{-0.6197f, 0.4502f, 0.6428f}, 0.14f},
                                  {{-0.6197f, -0.4502f, 0.6428f}, 0.14f},
                                  {{0.2367f, -0.7285f, 0.6428f}, 0.14f}};

// Return the share of a cone's light that passes the snow: five samples, each about twice as wide and as far
// away as the one before. start: of the first [cells]. The samples are narrower than the steps between them,
// so that a cone over level snow does not graze it.
inline float cone_light(const Density& snow, Vec3f p, Vec3f direction, float start) {
  const float h = snow.cell_size();
  float depth = 0, t = start;
  for (int l = 0; l + 1 < Density::levels; ++l) {
    const float width = std::max(t, 2.0f);
    depth += 0.7f * cell_depth * width * snow.sample(p + direction * ((t + 0.5f * width) * h), l);
    if (depth > 6.0f) return 0.0f;
    t += width;
  }
  return std::exp(-depth);
}

// Say whether any snow is near enough to matter to the sky above p.
inline bool snow_around(const Density& snow, Vec3f p) {
  return !snow.empty() && snow.level(Density::levels - 1).occupied(p);
}

// Return the sky's light [share of the open sky] on a surface at p with this normal. wrap: how far light
// creeps round the edge (0: matt, 1: fully).
inline float sky_light(const Density& snow, Vec3f p, Vec3f normal, float wrap, float start) {
  float light = 0;
  for (const SkyCone& cone : sky_cones) {
    const float facing = (dot(normal, cone.direction) + wrap) / (1.0f + wrap);
    if (facing > 0) light += cone.weight * facing * cone_light(snow, p, cone.direction, start);
  }
  return 1.333f * light;  // level open ground receives one
}

// Return the light [share] that the ground sends up to a surface at p with this normal.
inline float ground_light(const Density& snow, Vec3f p, Vec3f normal, float start) {
  const float facing = 0.5f - 0.5f * normal.z;
  if (facing < 0.02f) return 0.0f;
  return facing *
         cone_light(snow, p, normalize({normal.x, normal.y, std::min(normal.z, 0.0f) - 0.5f}), start);
}

// Share of the sun left to a grain of snow by all solids. clear: how far off meshes begin to count [m]: grains
// sink into them a little.
inline float sun_past(const SolidSet& set, Vec3f p, Vec3f sun, float clear) {
  float seen = 1.0f;
  set.each_toward_sun(p, sun, [&](const Solid& solid) {
    seen *= sun_past(solid, p, sun, clear);
    return true;
  });
  return seen;
}

// Share of the sun left to a point of `self` by all solids that rest, or by all others. Only meshes throw shadows on
// themselves.
inline float sun_past(const SolidSet& set, bool is_static, const Solid& self, Vec3f p, const Hit& hit,
                      Vec3f sun) {
  // it has none to lose
  if (dot(hit.normal, sun) <= 0 || set.none(is_static)) return 1.0f;
  float seen = 1.0f;
  set.each_toward_sun(p + hit.lift, sun, [&](const Solid& solid) {
    if (solid.is_static == is_static && (&solid != &self || solid.mesh))
      seen *= sun_past(solid, p + hit.lift, sun, &solid == &self ? 1e-3f * solid.mesh->shade() : 0.0f);
    return seen > 0.001f;
  });
  return seen;
}

// Share of the sky left to a grain of snow by all solids.
inline float sky_past(const SolidSet& set, Vec3f p, Vec3f normal) {
  float seen = 1.0f;
  set.each_around(p, [&](const Solid& solid) {
    seen *= sky_past(solid, p, normal);
    return true;
  });
  return seen;
}

// Share of the sky left to a point of `self` by all solids that rest, or by all others.
inline float sky_past(const SolidSet& set, bool is_static, const Solid& self, Vec3f p, Vec3f normal) {
  if (set.none(is_static)) return 1.0f;
  float seen = 1.0f;
  set.each_around(p, [&](const Solid& solid) {
    if (solid.is_static == is_static)
      seen *= &solid == &self ? sky_past_self(solid, p, normal) : sky_past(solid, p, normal);
    return true;
  });
  return seen;
}

}  // namespace neve::render
