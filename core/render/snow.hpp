// Light on a grain of snow. What arrives is found once per visible particle; what each pixel sees of it
// depends on the grain's own roundness.
#pragma once

#include "render/ground.hpp"

namespace neve::render {

// Light at one particle.
struct Lit {
  Vec3f normal{};  // of the snow's surface around it
  Vec3f sun{};     // sun that arrives past snow and solids
  Vec3f around{};  // sky, ground and light that has wandered through the snow
  float solid =
      1;  // share of a pixel's background that is snow as well (1 inside a heap, 0 for a lone flake)
};

// Find the surface's normal from the density at three scales; a lone flake has none and looks at the sky.
inline Vec3f snow_normal(const Density& snow, Vec3f p) {
  const Vec3f slope = snow.slope(p, 0) * 0.5f + snow.slope(p, 1) + snow.slope(p, 2) * 0.6f;
  return normalize(slope * -1.0f + Vec3f{0, 0, 0.03f});
}

inline Lit light_particle(const Density& snow, const SolidSet& set, const Light& light, Vec3f p) {
  const float h = snow.cell_size();
  Lit lit;
  lit.normal = snow_normal(snow, p);
  // Light is asked for just above the surface, and higher for grains that lie deeper.
  const float cover = snow.sample(p);
  const Vec3f above = p + lit.normal * (h * (0.8f + 0.6f * saturate(cover - 0.3f)));
  const float past = sun_past(set, p, light.sun, h);
  const SunPath path = sun_path(snow, above, light.sun, 0.25f, 1.8f);
  const float direct = std::exp(-path.far - (0.55f - 0.3f * saturate(cover)) * path.near),
              through = std::exp(-0.38f * (path.near + path.far));
  lit.sun = light.sun_color * (direct * past);
  const float sky = sky_light(snow, above, lit.normal, 0.35f, 0.5f) * sky_past(set, p, lit.normal);
  // Snow gives back nearly all light, so its hollows light themselves.
  const float bright = sky / (1.0f - 0.60f * (1.0f - saturate(sky)));
  lit.around = light.sky_color * Vec3f{0.68f, 0.79f, 0.94f} * bright;
  // Where the sky is hidden, it is hidden by snow, which shines as well.
  lit.around +=
      (light.sun_color * Vec3f{0.062f, 0.074f, 0.090f} + light.sky_color * 0.16f) * (1.0f - saturate(sky));
  lit.around += (light.sun_color * (0.7f * std::max(light.sun.z, 0.0f)) + light.sky_color) *
                (0.20f * ground_light(snow, above, lit.normal, 0.5f));
  lit.around += light.sun_color * Vec3f{0.72f, 0.90f, 1.0f} * (0.14f * through * past);
  lit.solid = saturate(2.0f * snow.sample(p, 1));
  return lit;
}

// Fixed random bits of a grain, spelled out.
struct Facet {
  Vec3f normal{};
  float albedo;
};
inline Facet facet_of(std::uint32_t seed) {
  const std::uint32_t a = scramble(seed), b = scramble(a + 1);
  const auto byte = [](std::uint32_t bits, int shift) {
    return float(bits >> shift & 255u) * (1.0f / 255.0f);
  };
  return {normalize({byte(a, 0) - 0.5f, byte(a, 8) - 0.5f, byte(a, 16) - 0.5f}), 0.90f + 0.08f * byte(b, 0)};
}

// What of a grain's light is the same wherever it is seen. near: 1 where particles are large in the picture, whose grains
// shall not look like balls.
struct GrainSurface {
  Vec3f normal{};  // of the snow and the facet, before the grain's roundness
  Vec3f glint{};   // normal of the facet that mirrors the sun
  float albedo = 0;

  GrainSurface() = default;
  GrainSurface(const Lit& lit, std::uint32_t seed, float near) {
    const Facet facet = facet_of(seed);
    normal = lit.normal + facet.normal * (0.40f - 0.16f * near);
    glint = normalize(facet.normal + lit.normal * 0.8f);
    albedo = facet.albedo;
  }
};

// Light that a grain sends to the eye at a point where its own round surface has the normal `round`.
inline Vec3f grain_light(const GrainSurface& grain, const Lit& lit, const Light& light, Vec3f round,
                         Vec3f to_eye, float near) {
  const Vec3f normal = normalize(grain.normal + round * (0.40f - 0.28f * near));
  const float wrap = 0.12f;
  const float sun = std::max((dot(normal, light.sun) + wrap) / (1.0f + wrap), 0.0f);
  const float depth = 0.20f - 0.14f * near;
  const float rim =
      1.0f - depth + depth * saturate(dot(round, to_eye));  // grains shade the gaps between them
  const float open = 0.86f + 0.22f * dot(normal, lit.normal) * (0.6f + 0.4f * normal.z);  // to the sky
  Vec3f color = (lit.sun * sun + lit.around * open) * (grain.albedo * rim);
  // A few facets lie just so and send the sun into the lens.
  const float glint = dot(normalize(light.sun + to_eye), grain.glint);
  if (glint > 0.985f)
    color +=
        lit.sun * ((1.2f - 0.9f * near) * smoothstep(0.985f, 1.0f, glint) * saturate(dot(round, to_eye)));
  return color;
}

// Light of a grain of slush, of which the share `water` is liquid. Water between grains of ice takes the edges off: the
// snow throws back less, and bluer, light, its facets are drowned, and a film of water mirrors the sun.
// dry: the light of the grain when it is dry.
inline Vec3f slush_light(Vec3f dry, const Lit& lit, const Light& light, Vec3f round, Vec3f to_eye,
                         std::uint32_t seed, float water) {
  const float film = saturate(2.0f * water);
  const Vec3f normal = normalize(lit.normal + round * 0.12f + facet_of(seed).normal * 0.05f);
  const float sun = std::max((dot(normal, light.sun) + 0.12f) / 1.12f, 0.0f);
  const Vec3f slush{0.78f, 0.82f, 0.84f}, soaked{0.47f, 0.56f, 0.61f};  // over the albedo of dry snow
  const Vec3f tint = water < 1.0f / 3.0f ? mix(Vec3f{1, 1, 1}, slush, 3.0f * water)
                                         : mix(slush, soaked, 1.5f * water - 0.5f);
  const Vec3f smooth = (lit.sun * sun + lit.around) * 0.92f;
  const Vec3f half = normalize(light.sun + to_eye);
  const float glint = std::pow(saturate(dot(half, normal)), 50.0f);
  const float slant = 1.0f - saturate(dot(normal, to_eye));
  const float mirror =
      0.02f + 0.60f * slant * slant * slant * slant * slant;  // Schlick 1994, of a rough film
  return mix(dry, smooth, film) * tint + (lit.around * mirror + lit.sun * (0.35f * glint)) * film;
}

// Light of a drop of water before what shines `behind`: clear, with the sky and the sun on it. ray: of unit length.
inline Vec3f drop_light(Vec3f behind, const Lit& lit, const Light& light, const Sky& sky, Vec3f round,
                        Vec3f ray) {
  const float slant = 1.0f - saturate(-dot(round, ray));
  const float mirror = 0.02f + 0.98f * slant * slant * slant * slant * slant;  // Schlick 1994, water in air
  const Vec3f half = normalize(light.sun - ray);
  const float glint = std::pow(saturate(dot(half, round)), 80.0f);
  // Rays bend through it towards the other side: the lower half is bright with sky.
  const Vec3f through = mix(behind, sky.toward(ray * -1.0f, light), 0.25f * saturate(-round.z));
  return through * (1.0f - mirror) + sky.toward(ray - round * (2.0f * dot(round, ray)), light) * mirror +
         lit.sun * (1.5f * glint);
}

}  // namespace neve::render
