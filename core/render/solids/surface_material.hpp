// What surfaces are made of: frozen ground, rock, paint, metal, rubber, wood. All of it is a function of position, so
// nothing is stored and nothing shimmers from frame to frame.
#pragma once

#include "render/solids/solids.hpp"

namespace neve::render {

struct Relief {
  float value, du, dv;  // height in [-1, 1] and its slopes
};

// Smooth noise on a lattice of unit squares: random heights at the corners, a quintic between them.
inline Relief noise(float u, float v, std::uint32_t seed) {
  const float fu = std::floor(u), fv = std::floor(v);
  const std::uint32_t i = std::uint32_t(std::int64_t(fu)), j = std::uint32_t(std::int64_t(fv));
  const auto corner = [seed](std::uint32_t a, std::uint32_t b) {
    return 2.0f * unit(scramble(a * 0x9e3779b1u ^ scramble(b + seed))) - 1.0f;
  };
  const float a = u - fu, b = v - fv;
  const float p = a * a * a * (a * (6 * a - 15) + 10), q = b * b * b * (b * (6 * b - 15) + 10);
  const float dp = 30 * a * a * (a - 1) * (a - 1), dq = 30 * b * b * (b - 1) * (b - 1);
  const float c00 = corner(i, j), c10 = corner(i + 1, j), c01 = corner(i, j + 1), c11 = corner(i + 1, j + 1);
  const float low = mix(c00, c10, p), high = mix(c01, c11, p);
  return {mix(low, high, q), dp * mix(c10 - c00, c11 - c01, q), dq * (high - low)};
}

// Add octaves of noise down to the size of a pixel, where they fade out before they can alias.
// size: of the largest features [m]; pixel: footprint of a pixel [m].
inline Relief fractal(float u, float v, float size, int octaves, float gain, float pixel,
                      std::uint32_t seed) {
  Relief sum{0, 0, 0};
  float weight = 1.0f;
  for (int o = 0; o < octaves; ++o) {
    const float fade = saturate(size / (2.0f * pixel) - 0.5f);
    if (fade <= 0) break;
    const Relief n = noise(u / size, v / size, seed + std::uint32_t(o));
    sum.value += fade * weight * n.value;
    sum.du += fade * weight * n.du / size;
    sum.dv += fade * weight * n.dv / size;
    weight *= gain;
    // Turn each octave, or the lattices show as a plaid.
    const float turned = 0.8f * u - 0.6f * v;
    v = 0.6f * u + 0.8f * v;
    u = turned;
    size *= 0.47f;
  }
  return sum;
}

// How a surface takes the light.
struct Finish {
  Vec3f color{};  // share that is scattered all around
  Vec3f normal{};
  Vec3f mirror{};     // share that is reflected straight on
  float gleam = 0;    // of the sun, where it is reflected: strength
  float narrow = 40;  // and how narrow: exponent of the cosine
};

// Frozen ground: dark soil, hoarfrost in drifts, a fine crust that catches a low sun; rock where it is steep.
// normal: of the surface, in its own frame; reach: size of the scene [m]; pixel: footprint of a pixel [m].
inline Finish frozen_ground(Vec3f p, Vec3f normal, float reach, float pixel) {
  const Relief drift = fractal(p.x, p.y, 0.60f * reach, 6, 0.50f, pixel, 11);
  const Relief crust = fractal(p.x, p.y, 0.013f * reach, 4, 0.75f, pixel, 71);
  // Hoarfrost lies on the grains of the crust first: they break the edges of the drifts.
  const float frost = smoothstep(-0.7f, 1.25f, drift.value + 0.40f * crust.value);
  const Vec3f soil{0.150f, 0.138f, 0.128f}, rime{0.330f, 0.348f, 0.380f}, rock{0.118f, 0.113f, 0.112f};
  Vec3f color = mix(soil, rime, frost) * (1.0f + 0.15f * crust.value);
  const float steep = 1.0f - smoothstep(0.70f, 0.88f, normal.z + 0.06f * crust.value);
  if (steep > 0) {
    const Relief layer = fractal(p.x + 0.6f * p.z, p.y - 0.8f * p.z, 0.05f * reach, 5, 0.6f, pixel, 211);
    color = mix(color, rock * (1.0f + 0.45f * layer.value + 0.15f * crust.value), steep);
  }
  const float bump = 0.0011f * reach;
  return {color, normalize(normal + Vec3f{-bump * crust.du, -bump * crust.dv, 0.0f})};
}

// Wood: fibres along the longest axis, seasons across.
inline float wood_grain(const Solid& solid, Vec3f p, float pixel) {
  const int axis = longest_axis(solid.place.kind, solid.place.half);
  const Vec3f q{p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis]};
  const float size = std::min(0.22f * solid.bound, 0.25f), along = q.z * 0.10f;
  const Relief season = fractal(q.x + 0.6f * q.y, along, size, 3, 0.55f, pixel, 307);
  const Relief fibre = fractal(q.x - 0.8f * q.y, 0.3f * along, 0.12f * size, 3, 0.7f, pixel, 311);
  return 0.35f * season.value + 0.22f * fibre.value;
}

// The surface of a solid of some colour, with a little wear, so that large flat sides are not dead.
// direction: of the ray that sees it, of unit length.
inline Finish finish(const Solid& solid, Vec3f point, Vec3f normal, Vec3f direction, float pixel) {
  const Vec3f p = solid.local(point);
  const float size = 0.5f * std::min(solid.bound, 4.0f);
  const Relief wear = fractal(p.x + 0.37f * p.z, p.y + 0.71f * p.z, size, 5, 0.6f, pixel, 131);
  const float slant = 1.0f - saturate(-dot(normal, direction));
  const float grazing = slant * slant * slant * slant * slant;  // Schlick 1994, equation 15
  switch (solid.material) {
    case SurfaceMaterial::metal: {
      const Vec3f color = solid.color * (1.0f + 0.06f * wear.value);
      const Vec3f bright{std::min(2.2f * color.x, 0.92f), std::min(2.2f * color.y, 0.92f),
                         std::min(2.2f * color.z, 0.92f)};
      return {color * 0.30f, normal, mix(bright, {1, 1, 1}, grazing) * 0.75f, 1.3f, 48.0f};
    }
    case SurfaceMaterial::rubber:
      return {solid.color * (0.95f + 0.10f * wear.value), normal, Vec3f{0.25f, 0.25f, 0.25f} * grazing, 0.05f,
              9.0f};
    case SurfaceMaterial::wood:
      return {solid.color * std::max(1.0f + wood_grain(solid, p, pixel), 0.2f), normal,
              Vec3f{0.3f, 0.3f, 0.3f} * grazing, 0.05f, 18.0f};
    case SurfaceMaterial::stone: {
      const Relief grit = fractal(p.x - 0.53f * p.z, p.y + 0.61f * p.z, 0.12f * size, 5, 0.75f, pixel, 177);
      return {solid.color * (1.0f + 0.28f * wear.value + 0.22f * grit.value),
              normalize(normal + solid.place.rotation * Vec3f{-grit.du, -grit.dv, 0.0f} * (0.008f * size))};
    }
    default:  // paint and a coat of varnish
      return {solid.color * (1.0f + 0.10f * wear.value), normal,
              Vec3f{0.6f, 0.6f, 0.6f} * mix(0.04f, 1.0f, grazing), 0.12f, 40.0f};
  }
}

}  // namespace neve::render
