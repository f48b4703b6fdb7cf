// Light on a grain of snow. What arrives is found once per visible particle; what each pixel sees of it depends
// on the grain's own roundness.
#pragma once
#include "look/ground.hpp"

namespace neve::look {

/// Light at one particle.
struct Lit {
  Vec3 normal;         // of the snow's surface around it
  Vec3 sun;            // sun that arrives past snow and bodies
  Vec3 around;         // sky, ground and light that has wandered through the snow
  float solid = 1;     // share of a pixel's background that is snow as well (1 inside a heap, 0 for a lone flake)
};

/// Find the surface's normal from the density at two scales; a lone flake has none and looks at the sky.
inline Vec3 snow_normal(const Density& snow, Vec3 p) {
  const float h = snow.cell_size();
  const Vec3 slope = snow.gradient(p, 0) * 0.6f + snow.gradient(p, 1);
  return normalize(slope * -h + Vec3{0, 0, 0.03f});
}

inline Lit light_particle(const Density& snow, std::span<const Body> bodies, const Light& light, Vec3 p) {
  const float h = snow.cell_size();
  Lit lit;
  lit.normal = snow_normal(snow, p);
  const Vec3 above = p + lit.normal * (0.9f * h);
  const float past = sun_past(bodies, nullptr, p, light.sun);
  // Surface light starts outside the surface; light that has come through the snow starts at the grain itself.
  const float direct = std::exp(-sun_depth(snow, above, light.sun, 0.6f * h));
  const float through = std::exp(-0.42f * sun_depth(snow, p, light.sun, 0.25f * h, 12.0f));
  lit.sun = light.sun_color * (direct * past);
  const float sky = sky_light(snow, above, lit.normal, 0.5f, 0.5f) * sky_past(bodies, nullptr, p, lit.normal);
  const float ground = ground_light(snow, above, lit.normal, 0.5f);
  // Snow gives back nearly all light, so its hollows light themselves.
  const float bright = sky / (1.0f - 0.62f * (1.0f - saturate(sky)));
  lit.around = light.sky_color * bright;
  lit.around += (light.sun_color * 0.7f * std::max(light.sun.z, 0.0f) + light.sky_color) * (0.22f * ground);
  lit.around += light.sun_color * Vec3{0.80f, 0.92f, 1.0f} * (0.16f * through * past);
  lit.solid = saturate(2.0f * snow.sample(p, 1));
  return lit;
}

/// Light that a grain sends to the eye at a point where its own round surface has the normal `round`.
/// seed: the grain's fixed random bits.
inline Vec3 grain_light(const Lit& lit, const Light& light, Vec3 round, Vec3 to_eye, uint32_t seed) {
  const uint32_t a = scramble(seed), b = scramble(a + 1), c = scramble(b + 1);
  const Vec3 facet = normalize({unit(a) - 0.5f, unit(b) - 0.5f, unit(c) - 0.5f});
  const Vec3 normal = normalize(lit.normal + round * 0.55f + facet * 0.35f);
  const float wrap = 0.22f;
  const float sun = std::max((dot(normal, light.sun) + wrap) / (1.0f + wrap), 0.0f);
  const float rim = 0.72f + 0.28f * saturate(dot(round, to_eye));   // grains shade the gaps between them
  const float albedo = 0.90f + 0.09f * unit(c);
  Vec3 color = (lit.sun * sun + lit.around) * (albedo * rim);
  // A few facets lie just so and send the sun into the lens.
  const Vec3 half = normalize(light.sun + to_eye);
  const Vec3 tilted = normalize(facet + lit.normal * 0.8f);
  const float glint = dot(half, tilted);
  if (glint > 0.985f) color += lit.sun * (1.2f * smoothstep(0.985f, 1.0f, glint) * saturate(dot(round, to_eye)));
  return color;
}

}  // namespace neve::look
