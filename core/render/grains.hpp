// From particles to grains on the film: each particle is drawn as a cluster of smaller grains at fixed random
// places around it, so the picture is finer than the simulation and nothing jumps from frame to frame.
#pragma once

#include <vector>

#include "render/burial.hpp"
#include "render/light.hpp"
#include "render/view/camera.hpp"

namespace neve::render {

struct Grain {
  float column, row;  // of the centre [samples]
  float depth;        // of the centre [m]
  float radius;       // [m]
  float wide;         // radius [samples]
  std::uint32_t particle;
  std::uint32_t seed;
};

// How a particle becomes grains. Snow that comes loose falls into more and smaller grains, without a jump.
class Cluster {
 public:
  static constexpr int most = 16;    // grains of one particle, where it is small in the picture
  static constexpr int finest = 96;  // and where it is large

  // spacing: between neighbouring particles of solid snow [m]; n: number of particles.
  Cluster(float spacing, std::size_t n, const Camera& camera) {
    // Grains a pixel or two apart where the camera looks. Of solid snow only the surface is drawn; loose snow
    // shows every particle, and gets no more grains than two cores can draw in time.
    const float pixels = spacing * camera.focal / camera.reach;
    solid_ = int(std::clamp(std::pow(pixels / 1.35f, 3.0f), 1.0f, float(most)));
    // Where that many would be beads, three pixels wide, there are more, which lie closer to the eye.
    const float fine = std::min(std::pow(pixels / 1.7f, 3.0f), float(finest));
    near_ = saturate((pixels - 5.4f) / 1.2f);
    solid_ = std::max(solid_, int(mix(1.0f, fine, near_)));
    loose_ = int(std::clamp(1.6e6f / float(std::max<std::size_t>(n, 1)), 1.0f, float(most)));
    loose_ = std::min(loose_, 3 * solid_);
    spread_ = solid_ > 1 || loose_ > 1 ? 0.66f * spacing : 0.0f;
    solid_radius_ = 0.68f * spacing / std::cbrt(float(solid_));
    loose_radius_ = 0.68f * spacing / std::cbrt(float(loose_));
    drop_ = 0.46f * spacing;
    for (std::uint32_t o = 0; o < places; ++o) place_[o] = in_ball(o);
  }

  int grains(float loose) const {
    return loose <= 0 ? solid_ : loose >= 1 ? loose_ : std::max(solid_, loose_);
  }
  // 0 where particles are small in the picture, 1 where they are so large that their grains must not look like balls.
  float near() const { return near_; }

  // Whether a grain of solid snow lies so far behind its particle that others of the particle hide it.
  // toward: unit vector to the eye.
  bool hidden(Vec3f offset, float loose, Vec3f toward) const {
    return solid_ > most && loose <= 0 && dot(offset, toward) < -0.25f * spread_;
  }
  float reach() const {
    return 2.5f * (spread_ + std::max(solid_radius_, loose_radius_));
  }  // no grain lies farther from its particle [m]
  static std::uint32_t seed(std::uint32_t particle, int g) {
    const std::uint32_t first = scramble(particle * std::uint32_t(most) + std::uint32_t(g % most));
    return g < most ? first : scramble(first + std::uint32_t(g / most));
  }

  // How a loose particle looks, from a clod (0) to a puff of powder (1); most are nearer to clods.
  static float powder(std::uint32_t particle) {
    const float u = unit(scramble(particle ^ 0x5bd1e995u));
    return u * u;
  }
  // Place of a grain around its particle [m]. wider: how much the particle's snow has dilated along one
  // axis.
  Vec3f offset(std::uint32_t seed, float loose, float powder, float wider) const {
    return place_[seed & (places - 1)] * (spread_ * wider * mix(1.0f, 0.72f + 1.7f * powder, loose));
  }
  // Radius of a drop of water [m]: of about the water of a particle, uneven.
  float drop(std::uint32_t particle) const { return drop_ * (0.6f + 0.5f * powder(particle)); }

  // Radius of grain g [m]: it shrinks to nothing where its snow has fewer grains.
  float radius(std::uint32_t seed, int g, float loose, float powder) const {
    const float u = float(seed >> 24) * (1.0f / 256.0f), uneven = 0.65f + 0.75f * u * u;
    const float in_solid = g < solid_ ? solid_radius_ : 0.0f;
    const float in_loose = g < loose_ ? (0.70f - 0.38f * powder) * loose_radius_ : 0.0f;
    return uneven * mix(in_solid, in_loose, loose);
  }

 private:
  static constexpr std::uint32_t places = 1024;

  static Vec3f in_ball(std::uint32_t o) {
    const float z = 2 * unit(scramble(4 * o + 1)) - 1, turn = 6.2831853f * unit(scramble(4 * o + 2));
    const float out = std::cbrt(unit(scramble(4 * o + 3))), flat = out * std::sqrt(1 - z * z);
    return {flat * std::cos(turn), flat * std::sin(turn), out * z};
  }

  int solid_, loose_;                  // grains of a particle in solid and in loose snow
  float spread_;                       // radius of a cluster [m]
  float solid_radius_, loose_radius_;  // of their grains [m]
  float near_;                         // see `near`
  float drop_;                         // radius of a drop of water [m]
  Vec3f place_[places];
};

// The particles' grains on the film.
class Projection {
 public:
  // samples: per pixel and axis. J_P, water: empty, or one per particle.
  Projection(const Density& snow, std::span<const Vec3f> x, std::span<const float> J_P,
             std::span<const float> water, const Camera& camera, const Cluster& cluster, int samples)
      : snow_(snow),
        x_(x),
        J_P_(J_P),
        water_(water),
        camera_(camera),
        cluster_(cluster),
        burial_(snow, camera.eye),
        samples_(float(samples)) {}

  // Return all grains that can show, in the order of the particles.
  std::vector<Grain> grains() const {
    constexpr std::size_t chunk = 2048;  // fixed, so that the order does not depend on the threads
    const std::size_t chunks = (x_.size() + chunk - 1) / chunk;
    std::vector<std::vector<Grain>> parts(chunks);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t part = 0; part < chunks; ++part)
      for (std::size_t p = part * chunk; p < std::min(x_.size(), (part + 1) * chunk); ++p)
        add(p, parts[part]);
    std::vector<std::size_t> first(chunks + 1, 0);
    for (std::size_t part = 0; part < chunks; ++part) first[part + 1] = first[part] + parts[part].size();
    std::vector<Grain> all(first[chunks]);
#pragma omp parallel for schedule(static)
    for (std::size_t part = 0; part < chunks; ++part)
      std::copy(parts[part].begin(), parts[part].end(), all.begin() + long(first[part]));
    return all;
  }

 private:
  bool on_film(Vec3f at) const {
    const float margin = camera_.focal * cluster_.reach() / std::max(at.z, 1e-6f);
    const float w = 0.5f * float(camera_.width), h = 0.5f * float(camera_.height);
    // Written so that NaN is not on film.
    return at.z > 0.01f * camera_.reach && std::abs(at.x - w) < w + margin && std::abs(at.y - h) < h + margin;
  }

  void add(std::size_t p, std::vector<Grain>& out) const {
    const bool drop = !water_.empty() && water_[p] >= 1;
    const Vec3f x = x_[p];
    if (!drop && burial_.deep(x, snow_.home(p))) return;
    const Vec3f middle = camera_.project(x);
    if (!on_film(middle)) return;
    if (drop) {  // one smooth ball
      push(middle, cluster_.drop(std::uint32_t(p)), p, Cluster::seed(std::uint32_t(p), 0), out);
      return;
    }
    if (burial_.buried(x)) return;
    const float loose = 1.0f - smoothstep(0.12f, 0.5f, snow_.sample(x));
    const float wider = J_P_.empty() ? 1.0f : std::clamp(std::cbrt(J_P_[p]), 0.9f, 1.35f);
    const float powder = Cluster::powder(std::uint32_t(p));
    const int count = cluster_.grains(loose);
    const Vec3f toward = normalize(camera_.eye - x);
    for (int g = 0; g < count; ++g) {
      const std::uint32_t seed = Cluster::seed(std::uint32_t(p), g);
      const Vec3f offset = cluster_.offset(seed, loose, powder, wider);
      if (cluster_.hidden(offset, loose, toward)) continue;
      const Vec3f at = camera_.project(x + offset);
      if (!(at.z > 0.01f * camera_.reach)) continue;
      push(at, cluster_.radius(seed, g, loose, powder), p, seed, out);
    }
  }

  void push(Vec3f at, float radius, std::size_t p, std::uint32_t seed, std::vector<Grain>& out) const {
    out.push_back({samples_ * at.x, samples_ * at.y, at.z, radius, samples_ * camera_.focal * radius / at.z,
                   std::uint32_t(p), seed});
  }

  const Density& snow_;
  std::span<const Vec3f> x_;
  std::span<const float> J_P_;
  std::span<const float> water_;
  const Camera& camera_;
  const Cluster& cluster_;
  Burial burial_;
  float samples_;
};

}  // namespace neve::render
