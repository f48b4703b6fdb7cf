// A picture of snow, start to end: density, grains, z-buffer, light, film.
#pragma once

#include "render/backdrop.hpp"
#include "render/snow.hpp"
#include "render/splat.hpp"
#include "render/view/film_curve.hpp"

namespace neve::render {

struct Particles {
  std::span<const Vec3f> x;      // [m]
  std::span<const float> J_P;    // empty, or one per particle: loose snow is drawn looser
  std::span<const float> water;  // empty, or the liquid share of each particle
  float volume;                  // of one particle [m3]
  float cell_size;               // of the density grid [m]
};

// Draw one frame after the other with the same camera and light. A frame depends on its own input only;
// what stays the same from one to the next is kept to save time.
class Painter {
 public:
  // leaf: solids in a leaf of the tree over them, which changes the time that a picture takes and nothing else.
  Painter(const Camera& camera, const Light& light, std::uint32_t leaf)
      : camera_(camera),
        light_(light),
        backdrop_(camera, light, leaf),
        meshes_(camera),
        still_(camera),
        samples_(camera) {}

  const Camera& camera() const { return camera_; }

  // Draw into rgb, height x width x 3 bytes.
  void draw(const Particles& particles, const std::vector<Solid>& solids, std::uint8_t* rgb) {
    const Density snow(particles.x, particles.volume, particles.cell_size);
    const Cluster cluster(std::cbrt(particles.volume), particles.x.size(), camera_);
    grains_ = Projection(snow, particles.x, particles.J_P, camera_, cluster, Samples::per_axis).grains();
    if (!known_ || !same_at_rest(solids, backdrop_.solids())) {
      meshes_ = Raster(solids, camera_, true);
      draw_still(still_, solids, meshes_, camera_);
      backdrop_.forget();
      known_ = true;
    }
    const Raster moving(solids, camera_, false);
    draw_samples(samples_, still_, solids, moving, grains_, camera_);
    backdrop_.place(solids, meshes_, moving);
    backdrop_.illuminate(snow, samples_);
    light_visible(snow, particles.x);
    water_ = particles.water;
    develop(rgb);
  }

 private:
  static bool same_at_rest(std::span<const Solid> now, std::span<const Solid> before) {
    return std::equal(now.begin(), now.end(), before.begin(), before.end(),
                      [](const Solid& a, const Solid& b) {
                        return a.is_static == b.is_static && (!a.is_static || a == b);
                      });
  }

  void light_visible(const Density& snow, std::span<const Vec3f> x) {
    std::vector<std::uint8_t> seen(x.size(), 0);
#pragma omp parallel for schedule(static)
    for (int r = 0; r < samples_.height; ++r) {
      const Key* row = samples_.row(r);
      for (int c = 0; c < samples_.width; ++c)
        if (index_of(row[c]) < first_solid)  // several threads may say so of the same particle
          __atomic_store_n(&seen[grains_[index_of(row[c])].particle], 1, __ATOMIC_RELAXED);
    }
    lit_.resize(x.size());
#pragma omp parallel for schedule(dynamic, 256)
    for (std::size_t p = 0; p < x.size(); ++p)
      if (seen[p]) lit_[p] = light_particle(snow, backdrop_.set(), light_, x[p]);
  }

  void develop(std::uint8_t* rgb) const {
#pragma omp parallel for schedule(dynamic, 8)
    for (int r = 0; r < camera_.height; ++r)
      for (int c = 0; c < camera_.width; ++c) expose(pixel(r, c), r, c, rgb);
  }

  // Light of grain `g` at the sample (row r, column c of samples). behind: gives the light of what is
  // behind it.
  template <class Behind>
  Vec3f snow(std::uint32_t g, int r, int c, const Behind& behind) const {
    constexpr float pixel = 1.0f / Samples::per_axis;
    const Grain& grain = grains_[g];
    const Lit& lit = lit_[grain.particle];
    const float inv = 1.0f / std::max(grain.wide, least_radius);
    const float a = (float(c) + 0.5f - grain.column) * inv, b = (float(r) + 0.5f - grain.row) * inv;
    const float up = std::sqrt(std::max(1.0f - a * a - b * b, 0.0f));
    const Vec3f round = camera_.right * a + camera_.down * b - camera_.forward * up;
    const Vec3f ray = camera_.through(pixel * (float(c) + 0.5f), pixel * (float(r) + 0.5f));
    Vec3f color = grain_light(lit, light_, round, -normalize(ray), grain.seed);
    if (!water_.empty() && water_[grain.particle] > 0)
      color = wet_light(color, behind(), lit, light_, round, -normalize(ray), water_[grain.particle]);
    const float far = haze(grain.depth, camera_.reach);
    if (far > 0) color = mix(color, backdrop_.sky().horizon, far);
    const float small = grain.wide / least_radius;
    if (small < 1 && lit.solid < 1) color = mix(behind(), color, mix(small * small, 1.0f, lit.solid));
    return color;
  }

  Vec3f pixel(int r, int c) const {
    constexpr int n = Samples::per_axis;
    const int middle = backdrop_.solid(r, c);
    Vec3f sum{}, set{};
    bool known = false;
    const auto set_light = [&] {
      if (!known) set = backdrop_.light(r, c);
      known = true;
      return set;
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const Key key = samples_.row(r * n + i)[c * n + j];
        const std::uint32_t index = index_of(key);
        const int solid = key == nothing ? -1 : int(index - first_solid);
        if (key != nothing && index < first_solid)
          sum += snow(index, r * n + i, c * n + j, set_light);
        else if (solid == middle)
          sum += set_light();
        else
          sum += backdrop_.light_beside(solid, r, c, i, j);
      }
    return sum * (1.0f / (n * n));
  }

  void expose(Vec3f light, int r, int c, std::uint8_t* rgb) const {
    const float u = (float(c) + 0.5f) / float(camera_.width) - 0.5f,
                v = (float(r) + 0.5f) / float(camera_.height) - 0.5f;
    const float lens = 1.0f - 0.38f * (u * u + v * v);  // corners darken, as through a lens
    const float dither = unit(scramble(std::uint32_t(r) * 65536u + std::uint32_t(c)));
    std::uint8_t* to = rgb + 3 * (std::size_t(r) * std::size_t(camera_.width) + std::size_t(c));
    to[0] = curve_(light.x * lens, dither);
    to[1] = curve_(light.y * lens, dither);
    to[2] = curve_(light.z * lens, dither);
  }

  Camera camera_;
  Light light_;
  FilmCurve curve_;
  Backdrop backdrop_;
  Raster meshes_;  // of the solids that rest
  Samples still_;  // the solids that rest
  Samples samples_;
  bool known_ = false;  // whether there is anything in the two
  std::vector<Grain> grains_;
  std::span<const float> water_;  // of the particles that are drawn
  std::vector<Lit> lit_;
};

}  // namespace neve::render
