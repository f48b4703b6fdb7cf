// The set around the snow: frozen ground, painted bodies' surface, sky and haze. All of it is a function of
// position, so nothing is stored and nothing shimmers from frame to frame.
#pragma once
#include "look/camera.hpp"
#include "look/light.hpp"

namespace neve::look {

struct Relief {
  float value, du, dv;   // height in [-1, 1] and its slopes
};

/// Smooth noise on a lattice of unit squares: random heights at the corners, a quintic between them.
inline Relief noise(float u, float v, uint32_t seed) {
  const float fu = std::floor(u), fv = std::floor(v);
  const uint32_t i = uint32_t(int32_t(fu)), j = uint32_t(int32_t(fv));
  const auto corner = [seed](uint32_t a, uint32_t b) {
    return 2.0f * unit(scramble(a * 0x9e3779b1u ^ scramble(b + seed))) - 1.0f;
  };
  const float a = u - fu, b = v - fv;
  const float p = a * a * a * (a * (6 * a - 15) + 10), q = b * b * b * (b * (6 * b - 15) + 10);
  const float dp = 30 * a * a * (a - 1) * (a - 1), dq = 30 * b * b * (b - 1) * (b - 1);
  const float c00 = corner(i, j), c10 = corner(i + 1, j), c01 = corner(i, j + 1), c11 = corner(i + 1, j + 1);
  const float low = mix(c00, c10, p), high = mix(c01, c11, p);
  return {mix(low, high, q), dp * mix(c10 - c00, c11 - c01, q), dq * (high - low)};
}

/// Add octaves of noise down to the size of a pixel, where they fade out before they can alias.
/// size: of the largest features [m]; pixel: footprint of a pixel [m].
inline Relief fractal(float u, float v, float size, int octaves, float gain, float pixel, uint32_t seed) {
  Relief sum{0, 0, 0};
  float weight = 1.0f;
  for (int o = 0; o < octaves; ++o) {
    const float fade = saturate(size / (2.0f * pixel) - 0.5f);
    if (fade <= 0) break;
    const Relief n = noise(u / size, v / size, seed + uint32_t(o));
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

struct Finish {
  Vec3 color;
  Vec3 normal;
};

/// Frozen ground: dark soil, hoarfrost in drifts, a fine crust that catches a low sun. reach: size of the scene [m].
inline Finish frozen_ground(const Body& body, Vec3 point, float reach, float pixel) {
  const Vec3 p = body.turn.to_local(point - body.position);
  const Relief drift = fractal(p.x, p.y, 0.45f * reach, 5, 0.55f, pixel, 11);
  const Relief crust = fractal(p.x, p.y, 0.028f * reach, 5, 0.62f, pixel, 71);
  const float frost = smoothstep(-0.75f, 1.1f, drift.value + 0.35f * crust.value);
  const Vec3 soil{0.105f, 0.110f, 0.122f}, rime{0.34f, 0.365f, 0.40f};
  const Vec3 color = mix(soil, rime, frost) * (1.0f + 0.16f * crust.value);
  const float bump = 0.0045f * reach * (0.5f + 0.5f * frost);
  const Vec3 local = normalize({-bump * crust.du, -bump * crust.dv, 1.0f});
  return {color, body.turn.to_world(local)};
}

/// Paint with a little wear, so that large flat sides are not dead.
inline Finish paint(const Body& body, Vec3 point, Vec3 normal, float pixel) {
  const Vec3 p = body.turn.to_local(point - body.position);
  const float size = 0.5f * std::min(body.bound, 4.0f);
  const Relief wear = fractal(p.x + 0.37f * p.z, p.y + 0.71f * p.z, size, 5, 0.6f, pixel, 131);
  return {body.color * (1.0f + 0.10f * wear.value), normal};
}

struct Sky {
  Vec3 zenith, horizon;
  explicit Sky(const Light& light)
      : zenith(light.sky_color * Vec3{0.26f, 0.36f, 0.50f}),
        horizon(light.sky_color * Vec3{0.80f, 0.74f, 0.68f} + light.sun_color * 0.035f) {}

  Vec3 toward(Vec3 unit_direction, const Light& light) const {
    const float up = std::max(unit_direction.z, 0.0f);
    const float glow = std::pow(saturate(0.5f + 0.5f * dot(unit_direction, light.sun)), 6.0f);
    return mix(horizon, zenith, 1.0f - std::exp(-5.0f * up)) + light.sun_color * (0.06f * glow);
  }
};

/// Share of the air's light over what is `far` away: none near the subject, all at the horizon.
inline float haze(float far, float reach) { return 1.0f - std::exp(-0.055f * std::max(far / reach - 1.2f, 0.0f)); }

/// Light that a surface point sends to the eye. self: the body that it lies on.
inline Vec3 surface_light(const Density& snow, std::span<const Body> bodies, const Body& self, const Light& light,
                          const Camera& camera, Vec3 point, Vec3 normal, float depth) {
  const Vec3 to_eye = normalize(camera.eye - point);
  const float slant = std::max(std::abs(dot(normal, to_eye)), 0.15f);
  const float pixel = depth / camera.focal / std::sqrt(slant);
  const Finish finish = self.natural ? frozen_ground(self, point, camera.reach, pixel) : paint(self, point, normal, pixel);
  float sun = std::max(dot(finish.normal, light.sun), 0.0f) * saturate(8.0f * dot(normal, light.sun));
  float sky = 0.5f + 0.5f * normal.z;
  if (sun > 0) sun *= sun_past(bodies, &self, point, light.sun);
  if (snow_around(snow, point)) sky = sky_light(snow, point, normal, 0.35f, 0.15f);
  if (sun > 0 && !snow.empty()) sun *= std::exp(-sun_depth(snow, point, light.sun, 0.3f * snow.cell_size()));
  sky *= sky_past(bodies, &self, point, normal);
  const Vec3 bounce = light.sun_color * (0.10f * (1.0f - std::abs(normal.z)));
  Vec3 color = finish.color * (light.sun_color * sun + light.sky_color * sky + bounce);
  if (!self.natural) {   // a coat of varnish
    const Vec3 half = normalize(light.sun + to_eye);
    color += light.sun_color * (0.12f * sun * std::pow(saturate(dot(finish.normal, half)), 40.0f));
  }
  return color;
}

}  // namespace neve::look
