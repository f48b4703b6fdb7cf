// The set around the snow: frozen ground, painted bodies' surface, sky and haze. All of it is a function of
// position, so nothing is stored and nothing shimmers from frame to frame.
#pragma once
#include "look/camera.hpp"
#include "look/light.hpp"

namespace neve::look {

struct Relief {
  float value, du, dv;  // height in [-1, 1] and its slopes
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

/// Frozen ground: dark soil, hoarfrost in drifts, a fine crust that catches a low sun. reach: size of the
/// scene [m].
inline Finish frozen_ground(const Body& body, Vec3 point, float reach, float pixel) {
  const Vec3 p = body.turn.to_local(point - body.position);
  const Relief drift = fractal(p.x, p.y, 0.60f * reach, 6, 0.50f, pixel, 11);
  const Relief crust = fractal(p.x, p.y, 0.013f * reach, 4, 0.75f, pixel, 71);
  // Hoarfrost lies on the grains of the crust first: they break the edges of the drifts.
  const float frost = smoothstep(-0.7f, 1.25f, drift.value + 0.40f * crust.value);
  const Vec3 soil{0.150f, 0.138f, 0.128f}, rime{0.330f, 0.348f, 0.380f};
  const Vec3 color = mix(soil, rime, frost) * (1.0f + 0.15f * crust.value);
  const float bump = 0.0011f * reach;
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
      : zenith(light.sky_color * Vec3{0.30f, 0.50f, 0.82f}),
        horizon(light.sky_color * Vec3{1.55f, 1.58f, 1.50f} + light.sun_color * 0.05f) {}

  Vec3 toward(Vec3 unit_direction, const Light& light) const {
    const float up = std::max(unit_direction.z, 0.0f);
    const float glow = std::pow(saturate(0.5f + 0.5f * dot(unit_direction, light.sun)), 6.0f);
    return mix(horizon, zenith, 1.0f - std::exp(-6.5f * up)) + light.sun_color * (0.06f * glow);
  }
};

/// Share of the air's light over what is `far` away: none near the subject, all at the horizon.
inline float haze(float far, float reach) {
  return 1.0f - std::exp(-0.10f * std::max(far / reach - 1.25f, 0.0f));
}

/// Light from a point of the set: `sun` times the share of the sun that arrives, `sky` times that of the
/// sky, `rest`.
struct SetPoint {
  Vec3 sun, sky, rest;
};

inline SetPoint sky_point(const Sky& sky, const Light& light, Vec3 ray) {
  return {{}, {}, sky.toward(normalize(ray), light)};
}

/// Describe the point of a body that the ray from the eye meets first. All of it holds as long as body,
/// camera and light stay where they are.
inline SetPoint set_point(const Body& body, const Hit& hit, const Camera& camera, const Light& light,
                          const Sky& sky, Vec3 ray) {
  const Vec3 direction = normalize(ray), point = camera.eye + ray * hit.t;
  const float far = haze(length(ray) * hit.t, camera.reach);
  if (far > 0.995f) return sky_point(sky, light, ray);
  const float slant = std::max(std::abs(dot(hit.normal, direction)), 0.15f);
  const float pixel = hit.t / camera.focal / std::sqrt(slant);
  const Finish finish =
      body.natural ? frozen_ground(body, point, camera.reach, pixel) : paint(body, point, hit.normal, pixel);
  const float lit =
      std::max(dot(finish.normal, light.sun), 0.0f) * saturate(8.0f * dot(hit.normal, light.sun));
  SetPoint set;
  set.sun = finish.color * light.sun_color * lit;
  if (!body.natural && lit > 0) {  // a coat of varnish
    const Vec3 half = normalize(light.sun - direction);
    set.sun += light.sun_color * (0.12f * std::pow(saturate(dot(finish.normal, half)), 40.0f));
  }
  set.sun = set.sun * (1.0f - far);
  set.sky = finish.color * light.sky_color * (1.0f - far);
  set.rest = finish.color * light.sun_color * (0.10f * (1.0f - std::abs(hit.normal.z)) * (1.0f - far)) +
             sky.toward(normalize({direction.x, direction.y, 0.0f}), light) * far;
  return set;
}

/// Share of the sun that the snow leaves to a point of the set.
inline float sun_arrival(const Density& snow, const Light& light, Vec3 point) {
  return snow.empty() ? 1.0f : std::exp(-sun_path(snow, point, light.sun, 0.3f, 0.0f).far);
}

/// Share of the sky that snow and bodies leave to a point of the set.
inline float sky_arrival(const Density& snow, std::span<const Body> bodies, const Body& self, Vec3 point,
                         Vec3 normal) {
  const float open =
      snow_around(snow, point) ? sky_light(snow, point, normal, 0.35f, 0.1f) : 0.5f + 0.5f * normal.z;
  // What hides the sky is snow for the most part, which shines as well.
  return mix(0.14f, open, saturate(open)) * sky_past(bodies, &self, point, normal);
}

}  // namespace neve::look
