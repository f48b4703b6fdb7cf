// A picture of snow, start to end: density, grains, z-buffer, light, film.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "render/backdrop.hpp"
#include "render/falling.hpp"
#include "render/snow.hpp"
#include "render/splat.hpp"
#include "render/view/film_curve.hpp"

namespace neve::render {

struct Particles {
  std::span<const Vec3f> x;         // [m]
  std::span<const float> J_P;       // empty, or one per particle: loose snow is drawn looser
  std::span<const float> water;     // empty, or how wet each particle is: 1 is a drop, 0 dry snow
  float volume;                     // of one particle [m3]
  float cell_size;                  // of the density grid [m]
  std::span<const Puddle> puddles;  // water that lies on planes
  std::span<const Streak> falling;  // flakes in the air, the farthest first
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
        samples_(camera),
        picture_(std::size_t(camera.width) * std::size_t(camera.height) * 3),
        kept_(samples_.touched.size()) {}

  const Camera& camera() const { return camera_; }

  // Draw into rgb, height x width x 3 bytes.
  void draw(const Particles& particles, const std::vector<Solid>& solids, std::uint8_t* rgb) {
    const Density snow(particles.x, particles.volume, particles.cell_size);
    const Cluster cluster(std::cbrt(particles.volume), particles.x.size(), camera_);
    grains_ =
        Projection(snow, particles.x, particles.J_P, particles.water, camera_, cluster, Samples::per_axis)
            .grains();
    near_ = cluster.near();
    take_drops(particles.water);
    if (!known_ || !same_at_rest(solids, backdrop_.solids())) {
      meshes_ = Raster(solids, camera_, true);
      draw_still(still_, solids, meshes_, camera_);
      backdrop_.forget();
      std::fill(samples_.touched.begin(), samples_.touched.end(), 1);
      known_ = true;
    }
    const Raster moving(solids, camera_, false);
    draw_samples(samples_, still_, solids, moving, grains_, camera_);
    if (!drops_.empty()) splat_drops();
    backdrop_.place(solids, meshes_, moving);
    backdrop_.wet(particles.puddles);
    backdrop_.illuminate(snow, samples_);
    light_visible(snow, particles.x);
    water_ = particles.water;
    is_snowing_ = !particles.falling.empty();
    if (is_snowing_)
      veil_.draw(camera_.width, camera_.height, particles.falling,
                 [&](int r, int c) { return distance(r, c); });
    develop();
    std::copy(picture_.begin(), picture_.end(), rgb);
  }

 private:
  static bool same_at_rest(std::span<const Solid> now, std::span<const Solid> before) {
    return std::equal(now.begin(), now.end(), before.begin(), before.end(),
                      [](const Solid& a, const Solid& b) {
                        return a.is_static == b.is_static && (!a.is_static || a == b);
                      });
  }

  // Move the grains that are drops of water from `grains_` to `drops_`: they are clear, and drawn over the rest.
  void take_drops(std::span<const float> water) {
    drops_.clear();
    if (water.empty()) return;
    const auto is_snow = [&](const Grain& grain) { return water[grain.particle] < 1; };
    const auto first = std::stable_partition(grains_.begin(), grains_.end(), is_snow);
    drops_.assign(first, grains_.end());
    grains_.erase(first, grains_.end());
  }
  // Draw them into a z-buffer of their own.
  void splat_drops() {
    if (!over_) over_.emplace(camera_);
    Samples& over = *over_;
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < over.bands(); ++b) {
      const int first = b * Samples::band, last = std::min(first + Samples::band, over.height);
      std::fill(over.row(first), over.row(last - 1) + over.pitch, nothing);
      const std::size_t from = over.cell_at(first / Samples::cell, 0),
                        to = over.cell_at((last - 1) / Samples::cell + 1, 0);
      std::fill(over.touched.data() + from, over.touched.data() + to, 0);
      for (std::uint32_t g = 0; g < drops_.size(); ++g) {
        const float wide = std::max(drops_[g].wide, least_radius);
        if (drops_[g].row + wide >= float(first) && drops_[g].row - wide <= float(last))
          splat_grain(over, drops_[g], g, first, last);
      }
      for (std::size_t c = from; c < to; ++c) samples_.touched[c] |= over.touched[c];
    }
  }

  void light_visible(const Density& snow, std::span<const Vec3f> x) {
    std::vector<std::uint8_t> seen(x.size(), 0);
    // several threads may say so of the same particle
    const auto see = [&](const Grain& grain) {
      __atomic_store_n(&seen[grain.particle], 1, __ATOMIC_RELAXED);
    };
#pragma omp parallel for schedule(dynamic, 4)
    for (int i = 0; i < samples_.cell_rows(); ++i)
      for (int j = 0; j < samples_.cell_columns(); ++j) {
        if (!samples_.touched[samples_.cell_at(i, j)]) continue;
        samples_.each_of(i, j, [&](int r, int c, Key key) {
          if (index_of(key) < first_solid) see(grains_[index_of(key)]);
          if (drops_.empty()) return;
          const Key over = over_->row(r)[c];
          if (over < key) see(drops_[index_of(over)]);
        });
      }
    lit_.resize(x.size());
#pragma omp parallel for schedule(dynamic, 256)
    for (std::size_t p = 0; p < x.size(); ++p)
      if (seen[p]) lit_[p] = light_particle(snow, backdrop_.set(), light_, x[p]);
  }

  // Find the colours of all pixels. Cells in which nothing but rests shows, and whose light is that of the frame before,
  // are left as they are.
  void develop() {
#pragma omp parallel for schedule(dynamic, 2)
    for (int i = 0; i < samples_.cell_rows(); ++i)
      for (int j = 0; j < samples_.cell_columns(); ++j) {
        const std::size_t cell = samples_.cell_at(i, j);
        const bool rests = !samples_.touched[cell] && !is_veiled(i, j);
        if (rests && kept_[cell] && backdrop_.unchanged(i, j)) continue;
        Seen seen;
        for (int r = i * Backdrop::cell; r < std::min((i + 1) * Backdrop::cell, camera_.height); ++r)
          for (int c = j * Backdrop::cell; c < std::min((j + 1) * Backdrop::cell, camera_.width); ++c)
            expose(over(pixel(r, c, seen), r, c), r, c, picture_.data());
        kept_[cell] = rests && is_plain(i, j);
      }
  }

  // Whether a cell shows one solid, or the sky, and its light depends on the nodes of the backdrop's lattice alone.
  bool is_plain(int i, int j) const {
    const int solid = backdrop_.solid(i * Backdrop::cell, j * Backdrop::cell);
    bool same = true;
    samples_.each_of(i, j, [&](int r, int c, Key key) {
      const int found = key == nothing ? -1 : int(index_of(key) - first_solid);
      same = same && found == solid && backdrop_.solid(r / Samples::per_axis, c / Samples::per_axis) == solid;
    });
    return same && backdrop_.interpolates(i, j, solid);
  }

  bool is_veiled(int i, int j) const {
    constexpr int cell = Backdrop::cell;
    return is_snowing_ && veil_.shows(i * cell, (i + 1) * cell, j * cell, (j + 1) * cell);
  }
  Vec3f over(Vec3f light, int r, int c) const { return is_snowing_ ? veil_.over(r, c, light) : light; }
  // How far what is seen in a pixel is from the eye [m]: the nearest of its samples.
  float distance(int r, int c) const {
    constexpr int n = Samples::per_axis;
    Key nearest = nothing;
    for (int k = 0; k < n * n; ++k) {
      nearest = std::min(nearest, samples_.row(r * n + k / n)[c * n + k % n]);
    }
    if (nearest == nothing) return std::numeric_limits<float>::infinity();
    const float depth = std::bit_cast<float>(std::uint32_t(nearest >> 32));
    return depth * length(camera_.through(float(c) + 0.5f, float(r) + 0.5f));
  }

  // The normal of a grain's own round surface at the sample (row r, column c of samples).
  Vec3f round(const Grain& grain, int r, int c) const {
    const float inv = 1.0f / std::max(grain.wide, least_radius);
    const float a = (float(c) + 0.5f - grain.column) * inv, b = (float(r) + 0.5f - grain.row) * inv;
    const float up = std::sqrt(std::max(1.0f - a * a - b * b, 0.0f));
    return camera_.right * a + camera_.down * b - camera_.forward * up;
  }
  Vec3f ray(int r, int c) const {
    constexpr float pixel = 1.0f / Samples::per_axis;
    return camera_.through(pixel * (float(c) + 0.5f), pixel * (float(r) + 0.5f));
  }

  // Light of what shines `behind` through the drop `g` at a sample.
  Vec3f drop(std::uint32_t g, int r, int c, Vec3f behind) const {
    const Grain& grain = drops_[g];
    const Vec3f clear = drop_light(behind, lit_[grain.particle], light_, backdrop_.sky(), round(grain, r, c),
                                   normalize(ray(r, c)));
    const float small = std::min(grain.wide / least_radius, 1.0f);
    return mix(behind, clear, small * small * (1.0f - haze(grain.depth, camera_.reach)));
  }

  // A grain and its surface, which samples beside each other show.
  struct Seen {
    std::uint32_t grain = first_solid;  // none
    GrainSurface surface;
  };

  // Light of grain `g` at the sample (row r, column c of samples). behind: gives the light of what is
  // behind it. seen: the grain before.
  template <class Behind>
  Vec3f snow(std::uint32_t g, int r, int c, const Behind& behind, Seen& seen) const {
    const Grain& grain = grains_[g];
    const Lit& lit = lit_[grain.particle];
    const Vec3f round = this->round(grain, r, c), ray = this->ray(r, c);
    const float water = water_.empty() ? 0.0f : water_[grain.particle];
    if (seen.grain != g) seen = {g, {lit, grain.seed, near_}};
    Vec3f color = grain_light(seen.surface, lit, light_, round, -normalize(ray), near_);
    if (water > 0) color = slush_light(color, lit, light_, round, -normalize(ray), grain.seed, water);
    const float far = haze(grain.depth, camera_.reach);
    if (far > 0) color = mix(color, backdrop_.sky().horizon, far);
    const float small = grain.wide / least_radius;
    if (small < 1 && lit.solid < 1) color = mix(behind(), color, mix(small * small, 1.0f, lit.solid));
    return color;
  }

  Vec3f pixel(int r, int c, Seen& near) const {
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
        Vec3f seen;
        if (key != nothing && index < first_solid)
          seen = snow(index, r * n + i, c * n + j, set_light, near);
        else if (solid == middle)
          seen = set_light();
        else
          seen = backdrop_.light_beside(solid, r, c, i, j);
        if (!drops_.empty()) {
          const Key over = over_->row(r * n + i)[c * n + j];
          if (over < key) seen = drop(index_of(over), r * n + i, c * n + j, seen);
        }
        sum += seen;
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
  std::vector<std::uint8_t> picture_;  // of the frame before, height x width x 3
  std::vector<std::uint8_t> kept_;  // by cell: whether a pixel of it stays as it is as long as its nodes do
  bool known_ = false;              // whether there is anything in the two
  float near_ = 0;                  // see Cluster
  std::optional<Samples> over_;     // drops of water, where there are any
  bool is_snowing_ = false;         // whether flakes are drawn
  Veil veil_;
  std::vector<Grain> grains_, drops_;
  std::span<const float> water_;  // of the particles that are drawn
  std::vector<Lit> lit_;
};

}  // namespace neve::render
