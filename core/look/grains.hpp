// From particles to grains on the film: each particle is drawn as a cluster of smaller grains at fixed random
// places around it, so the picture is finer than the simulation and nothing jumps from frame to frame.
#pragma once
#include <vector>

#include "look/camera.hpp"
#include "look/light.hpp"

namespace neve::look {

struct Grain {
  float column, row;   // of the centre [samples]
  float depth;         // of the centre [m]
  float radius;        // [m]
  float wide;          // radius [samples]
  uint32_t particle;
  uint32_t seed;
};

struct Grains {
  int per_particle;
  float spread;        // radius of a particle's cluster [m]
  float radius;        // mean radius of a grain [m]

  /// spacing: between neighbouring particles of solid snow [m]; n: number of particles.
  Grains(float spacing, size_t n, const Camera& camera) {
    // Grains about two pixels across where the camera looks, but no more than the cores can draw in time.
    const float pixels = spacing * camera.focal / camera.reach;
    const float wanted = std::pow(pixels / 1.9f, 3.0f), affordable = 1.6e6f / float(std::max<size_t>(n, 1));
    per_particle = int(std::clamp(std::min(wanted, affordable), 1.0f, 16.0f));
    spread = per_particle > 1 ? 0.68f * spacing : 0.0f;
    radius = 0.62f * spacing / std::cbrt(float(per_particle));
  }

  uint32_t seed(uint32_t particle, int g) const { return scramble(particle * 16u + uint32_t(g) + 0x51ed27u); }

  /// Place of grain g in its particle's cluster [m]: uniform in a ball.
  Vec3 offset(uint32_t seed) const {
    if (spread <= 0) return {};
    const float z = 2 * unit(scramble(seed + 1)) - 1, turn = 6.2831853f * unit(scramble(seed + 2));
    const float out = spread * std::cbrt(unit(scramble(seed + 3))), flat = out * std::sqrt(1 - z * z);
    return {flat * std::cos(turn), flat * std::sin(turn), out * z};
  }
  float size(uint32_t seed) const { return radius * (0.7f + 0.6f * unit(scramble(seed + 4))); }
};

/// Say whether so much snow lies between p and the eye that no grain of p can show.
inline bool buried(const Density& snow, Vec3 p, Vec3 eye) {
  const Vec3 to_eye = normalize(eye - p);
  const float h = snow.cell_size();
  float least = 1e30f;
  for (float step : {0.0f, 1.0f, 2.0f, 3.0f}) least = std::min(least, snow.sample(p + to_eye * (step * h)));
  return least > 0.55f;
}

/// Project all grains that can show. samples: per pixel and axis. The order is that of the particles.
/// loose: per particle, how much wider its cluster is (1: solid snow).
template <class Loose>
std::vector<Grain> project_grains(const Density& snow, std::span<const Vec3> x, const Camera& camera,
                                  const Grains& grains, int samples, const Loose& loose) {
  constexpr size_t chunk = 2048;   // fixed, so that the order does not depend on the threads
  const size_t chunks = (x.size() + chunk - 1) / chunk;
  std::vector<std::vector<Grain>> parts(chunks);
  const float w = float(camera.width * samples), h = float(camera.height * samples), s = float(samples);
#pragma omp parallel for schedule(dynamic)
  for (size_t part = 0; part < chunks; ++part) {
    for (size_t p = part * chunk; p < std::min(x.size(), (part + 1) * chunk); ++p) {
      const Vec3 at = camera.project(x[p]);
      const float margin = s * camera.focal * 2 * (grains.spread + grains.radius) / std::max(at.z, 1e-6f);
      if (!(at.z > 0.01f * camera.reach) || !(std::abs(s * at.x - 0.5f * w) < 0.5f * w + margin) ||
          !(std::abs(s * at.y - 0.5f * h) < 0.5f * h + margin) || buried(snow, x[p], camera.eye))
        continue;   // the comparisons also drop NaN
      const float wider = loose(p);
      for (int g = 0; g < grains.per_particle; ++g) {
        const uint32_t seed = grains.seed(uint32_t(p), g);
        const Vec3 spot = camera.project(x[p] + grains.offset(seed) * wider);
        if (!(spot.z > 0.01f * camera.reach)) continue;
        const float radius = grains.size(seed);
        parts[part].push_back({s * spot.x, s * spot.y, spot.z, radius, s * camera.focal * radius / spot.z, uint32_t(p), seed});
      }
    }
  }
  std::vector<Grain> all;
  size_t count = 0;
  for (const auto& part : parts) count += part.size();
  all.reserve(count);
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace neve::look
