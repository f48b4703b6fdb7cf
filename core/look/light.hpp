// Sun and sky through the snow: how much of each arrives at a point.
#pragma once
#include <span>

#include "look/bodies.hpp"
#include "look/density.hpp"

namespace neve::look {

struct Light {
  Vec3 sun;            // unit vector towards the sun
  Vec3 sun_color;      // irradiance on a surface that faces the sun
  Vec3 sky_color;      // irradiance of the whole sky on level ground
};

// Optical depth of one cell of solid snow. Grains at half a cell's distance and with as large a radius cross a
// beam 1.6 times per cell (n pi r^2); we take a little less, so that edges glow.
constexpr float cell_depth = 1.2f;

/// Return the optical depth of the snow between p and the sun, or at most `limit`.
/// start [m] keeps a surface from shading itself; the samples coarsen with the distance, like the sun's penumbra.
inline float sun_depth(const Density& snow, Vec3 p, Vec3 sun, float start, float limit = 7.0f) {
  constexpr int step_limit = 160;
  const float h = snow.cell_size();
  const Blocks &near = snow.level(2), &all = snow.level(Density::levels - 1);
  float t = start, end = 1e30f, depth = 0;
  all.clip(p, sun, t, end);
  for (int step = 0; step < step_limit && t < end && depth < limit; ++step) {
    const Vec3 q = p + sun * t;
    if (!all.occupied(q)) {
      t += all.exit(q, sun) + 0.01f * h;
    } else if (!near.occupied(q)) {
      t += near.exit(q, sun) + 0.01f * h;
    } else {
      const float width = std::max(1.0f, 0.06f * t / h);   // of the penumbra, in cells
      depth += cell_depth * width * snow.sample_between(p + sun * (t + 0.5f * width * h), std::log2(width));
      t += width * h;
    }
  }
  return std::min(depth, limit);
}

// Directions in which the sky is asked: one up, five around at 35 degrees, five at 5 degrees below the horizon for
// what the ground sends back. Fixed in the world, so the answers do not shimmer.
struct SkyCone {
  Vec3 direction;
  float weight;        // share of the sky's (or ground's) light; each kind sums to one
};
constexpr std::array<SkyCone, 6> sky_cones{{{{0.0f, 0.0f, 1.0f}, 0.30f},
                                            {{0.819f, 0.0f, 0.574f}, 0.14f},
                                            {{0.253f, 0.779f, 0.574f}, 0.14f},
                                            {{-0.663f, 0.481f, 0.574f}, 0.14f},
                                            {{-0.663f, -0.481f, 0.574f}, 0.14f},
                                            {{0.253f, -0.779f, 0.574f}, 0.14f}}};
constexpr std::array<SkyCone, 4> ground_cones{{{{0.906f, 0.0f, -0.423f}, 0.25f},
                                               {{0.0f, 0.906f, -0.423f}, 0.25f},
                                               {{-0.906f, 0.0f, -0.423f}, 0.25f},
                                               {{0.0f, -0.906f, -0.423f}, 0.25f}}};

/// Return the share of a cone's light that passes the snow: six samples, each twice as wide and as far as the last.
inline float cone_light(const Density& snow, Vec3 p, Vec3 direction, float start) {
  const float h = snow.cell_size();
  float depth = 0, t = start * h;
  for (int l = 0; l < Density::levels; ++l) {
    const float width = std::max(t, h);
    depth += 0.7f * cell_depth * (width / h) * snow.sample(p + direction * (t + 0.5f * width), l);
    if (depth > 6.0f) return 0.0f;
    t += width;
  }
  return std::exp(-depth);
}

/// Say whether any snow is near enough to matter to the sky above p.
inline bool snow_around(const Density& snow, Vec3 p) {
  return !snow.empty() && snow.level(Density::levels - 1).occupied(p);
}

/// Return the sky's light [share of the open sky] on a surface at p with this normal. wrap: how far light creeps
/// round the edge (0: matt, 1: fully).
inline float sky_light(const Density& snow, Vec3 p, Vec3 normal, float wrap, float start) {
  float light = 0;
  for (const SkyCone& cone : sky_cones) {
    const float facing = (dot(normal, cone.direction) + wrap) / (1.0f + wrap);
    if (facing > 0) light += cone.weight * facing * cone_light(snow, p, cone.direction, start);
  }
  return 1.425f * light;   // level open ground receives one
}

/// Return the light [share] that the ground sends up to a surface at p with this normal.
inline float ground_light(const Density& snow, Vec3 p, Vec3 normal, float start) {
  float light = 0;
  for (const SkyCone& cone : ground_cones) {
    const float facing = 0.5f + 0.5f * dot(normal, cone.direction);
    if (facing > 0.05f) light += cone.weight * facing * cone_light(snow, p, cone.direction, start);
  }
  return light;
}

/// Share of the sun left by all bodies but `self`.
inline float sun_past(std::span<const Body> bodies, const Body* self, Vec3 p, Vec3 sun) {
  float seen = 1.0f;
  for (const Body& body : bodies)
    if (&body != self) seen *= sun_past(body, p, sun);
  return seen;
}

/// Share of the sky left by all bodies but `self`.
inline float sky_past(std::span<const Body> bodies, const Body* self, Vec3 p, Vec3 normal) {
  float seen = 1.0f;
  for (const Body& body : bodies)
    if (&body != self) seen *= sky_past(body, p, normal);
  return seen;
}

}  // namespace neve::look
