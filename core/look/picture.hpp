// A picture of snow, start to end: density, grains, z-buffer, light, film.
#pragma once
#include <memory>

#include "look/snow.hpp"
#include "look/splat.hpp"

namespace neve::look {

struct Particles {
  std::span<const Vec3> x;            // [m]
  std::span<const float> J_P;         // empty, or one per particle: loose snow is drawn looser
  float volume;                       // of one particle [m3]
  float cell_size;                    // of the density grid [m]
};

/// Bend light like film: a straight foot, a long shoulder, so that bright snow keeps its texture.
inline float film_curve(float a) {
  a = std::max(a, 0.0f);
  return a * (1.0f + a * 0.045f) / (0.62f + a * 0.62f) ;
}

inline uint8_t to_byte(float linear, float dither) {
  const float a = saturate(linear);
  const float s = a <= 0.0031308f ? 12.92f * a : 1.055f * std::pow(a, 1.0f / 2.4f) - 0.055f;
  return uint8_t(std::min(255.0f, s * 255.0f + dither));
}

class Picture {
 public:
  Picture(const Particles& particles, std::span<const Body> bodies, const Camera& camera, const Light& light)
      : particles_(particles), bodies_(bodies), camera_(camera), light_(light), sky_(light),
        snow_(particles.x, particles.volume, particles.cell_size), samples_(camera) {}

  /// Draw into rgb, height x width x 3 bytes.
  void draw(uint8_t* rgb) {
    const Grains grains(std::cbrt(particles_.volume), particles_.x.size(), camera_);
    const auto loose = [this](size_t p) {
      return particles_.J_P.empty() ? 1.0f : std::clamp(std::cbrt(particles_.J_P[p]), 0.9f, 1.35f);
    };
    grains_ = project_grains(snow_, particles_.x, camera_, grains, Samples::per_axis, loose);
    draw_samples(samples_, bodies_, grains_, camera_);
    light_visible();
#pragma omp parallel for schedule(dynamic, 8)
    for (int r = 0; r < camera_.height; ++r)
      for (int c = 0; c < camera_.width; ++c) expose(pixel(r, c), r, c, rgb + 3 * (size_t(r) * size_t(camera_.width) + size_t(c)));
  }

 private:
  void light_visible() {
    std::vector<uint8_t> seen(particles_.x.size(), 0);
    for (Key key : samples_.key)
      if (index_of(key) < first_body) seen[grains_[index_of(key)].particle] = 1;
    lit_.assign(particles_.x.size(), Lit{});
#pragma omp parallel for schedule(dynamic, 256)
    for (size_t p = 0; p < seen.size(); ++p)
      if (seen[p]) lit_[p] = light_particle(snow_, bodies_, light_, particles_.x[p]);
  }

  /// Light of the set behind the snow: body or sky through the middle of pixel (r, c).
  Vec3 background(int body, int r, int c) const {
    const Vec3 ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f), direction = normalize(ray);
    if (body >= 0) {
      const Body& self = bodies_[size_t(body)];
      const Hit hit = meet(self, camera_.eye, ray);
      if (hit.t < 1e20f) {
        const Vec3 point = camera_.eye + ray * hit.t;
        const float far = haze(length(ray) * hit.t, camera_.reach);
        if (far > 0.995f) return sky_.toward(direction, light_);
        const Vec3 color = surface_light(snow_, bodies_, self, light_, camera_, point, hit.normal, hit.t);
        return mix(color, sky_.toward({direction.x, direction.y, 0.0f}, light_), far);
      }
    }
    return sky_.toward(direction, light_);
  }

  /// Light of grain `g` at the sample (row r, column c of samples), over `behind`.
  template <class Behind>
  Vec3 snow(uint32_t g, int r, int c, const Behind& behind) const {
    const Grain& grain = grains_[g];
    const Lit& lit = lit_[grain.particle];
    const float inv = 1.0f / std::max(grain.wide, least_radius);
    const float a = (float(c) + 0.5f - grain.column) * inv, b = (float(r) + 0.5f - grain.row) * inv;
    const float up = std::sqrt(std::max(1.0f - a * a - b * b, 0.0f));
    const Vec3 round = camera_.right * a + camera_.down * b - camera_.forward * up;
    const Vec3 ray = camera_.through(0.5f * (float(c) + 0.5f), 0.5f * (float(r) + 0.5f));
    Vec3 color = grain_light(lit, light_, round, -normalize(ray), grain.seed);
    const float far = haze(grain.depth, camera_.reach);
    if (far > 0) color = mix(color, sky_.horizon, far);
    const float small = grain.wide / least_radius;
    if (small < 1 && lit.solid < 1) color = mix(behind(), color, mix(small * small, 1.0f, lit.solid));
    return color;
  }

  Vec3 pixel(int r, int c) const {
    constexpr int n = Samples::per_axis;
    Vec3 sum{}, set{};
    int set_body = -2;   // the body whose light is in `set`; -1 is the sky, -2 nothing yet
    const auto set_light = [&](int body) {
      if (set_body != body) set = background(body, r, c);
      set_body = body;
      return set;
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const Key key = samples_.row(r * n + i)[c * n + j];
        const uint32_t index = index_of(key);
        if (key == nothing) sum += set_light(-1);
        else if (index >= first_body) sum += set_light(int(index - first_body));
        else sum += snow(index, r * n + i, c * n + j, [&] { return set_light(behind(r, c)); });
      }
    return sum * (1.0f / (n * n));
  }

  /// The body that the middle of a pixel would show without snow, or -1.
  int behind(int r, int c) const {
    const Vec3 ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
    int nearest = -1;
    float t = 1e20f;
    for (size_t b = 0; b < bodies_.size(); ++b) {
      const Hit hit = meet(bodies_[b], camera_.eye, ray);
      if (hit.t < t) {
        t = hit.t;
        nearest = int(b);
      }
    }
    return nearest;
  }

  void expose(Vec3 light, int r, int c, uint8_t* rgb) const {
    const float u = (float(c) + 0.5f) / float(camera_.width) - 0.5f, v = (float(r) + 0.5f) / float(camera_.height) - 0.5f;
    const float lens = 1.0f - 0.38f * (u * u + v * v);   // corners darken, as through a lens
    const float dither = unit(scramble(uint32_t(r) * 65536u + uint32_t(c)));   // no steps in the sky
    rgb[0] = to_byte(film_curve(light.x * lens), dither);
    rgb[1] = to_byte(film_curve(light.y * lens), dither);
    rgb[2] = to_byte(film_curve(light.z * lens), dither);
  }

  Particles particles_;
  std::span<const Body> bodies_;
  Camera camera_;
  Light light_;
  Sky sky_;
  Density snow_;
  Samples samples_;
  std::vector<Grain> grains_;
  std::vector<Lit> lit_;
};

}  // namespace neve::look
