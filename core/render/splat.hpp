// The z-buffer. Every sample keeps one 64-bit key, depth above index, and the smallest wins: the result
// does not depend on the order of drawing, nor on the number of threads.
#pragma once

#include <bit>

#include "render/grains.hpp"
#include "render/solids/raster.hpp"

namespace neve::render {

using Key = std::uint64_t;
constexpr std::uint32_t first_solid = 0xff000000u;  // indices from here on are solids
constexpr std::size_t most_solids = 0xffffffu - 1;
constexpr Key nothing = ~Key(0);
// Smaller grains are drawn this large [samples], enough to meet a sample wherever they are, and faded
// instead.
constexpr float least_radius = 0.71f;

inline Key make_key(float depth, std::uint32_t index) {
  return Key(std::bit_cast<std::uint32_t>(depth)) << 32 | index;
}
inline std::uint32_t index_of(Key key) { return std::uint32_t(key); }

struct Samples {
  static constexpr int per_axis = 2;
  static constexpr int band = 32;  // rows of samples drawn by one thread at a time
  static constexpr int lanes = 8;  // samples drawn at once; rows have room for them past their end
  static constexpr int cell = 8;   // rows and columns of a cell, of which it is known whether it is touched
  int width, height;
  std::size_t pitch;
  std::vector<Key> key;
  // By cell: whether anything may be drawn there but what rests, and whether a solid shows there.
  std::vector<std::uint8_t> touched, shows_solid;

  explicit Samples(const Camera& camera)
      : width(camera.width * per_axis),
        height(camera.height * per_axis),
        pitch(std::size_t(width) + lanes),
        key(pitch * std::size_t(height)),
        touched(std::size_t(cell_rows()) * std::size_t(cell_columns()), 1),
        shows_solid(touched.size()) {}
  int bands() const { return (height + band - 1) / band; }
  Key* row(int r) { return key.data() + std::size_t(r) * pitch; }
  const Key* row(int r) const { return key.data() + std::size_t(r) * pitch; }

  int cell_rows() const { return (height + cell - 1) / cell; }
  int cell_columns() const { return (width + cell - 1) / cell; }
  std::size_t cell_at(int i, int j) const {
    return std::size_t(i) * std::size_t(cell_columns()) + std::size_t(j);
  }
  int end_row(int i) const { return std::min((i + 1) * cell, height); }
  int end_column(int j) const { return std::min((j + 1) * cell, width); }
  // Note that rows [top, bottom] and columns [left, right] are drawn to.
  void touch(int top, int bottom, int left, int right) {
    if (left > right) return;
    for (int i = top / cell; i <= bottom / cell; ++i)
      for (int j = left / cell; j <= right / cell; ++j) touched[cell_at(i, j)] = 1;
  }
  // Call f(r, c, key) for each sample of cell (i, j).
  template <class F>
  void each_of(int i, int j, F&& f) const {
    for (int r = i * cell; r < end_row(i); ++r)
      for (int c = j * cell; c < end_column(j); ++c) f(r, c, row(r)[c]);
  }
};

inline bool is_solid(Key key) { return key != nothing && index_of(key) >= first_solid; }

// Cover the samples of the grain's disc in rows [first, last), each as deep as a ball is there.
inline void splat_grain(Samples& samples, const Grain& grain, std::uint32_t index, int first, int last) {
  constexpr int lanes = Samples::lanes;
  const float wide = std::max(grain.wide, least_radius), inv = 1.0f / wide;
  const int top = whole(std::ceil(grain.row - wide - 0.5f), first, last);
  const int bottom = whole(std::floor(grain.row + wide - 0.5f), first - 1, last - 1);
  const int left = whole(std::ceil(grain.column - wide - 0.5f), 0, samples.width);
  const int right = whole(std::floor(grain.column + wide - 0.5f), -1, samples.width - 1);
  if (top > bottom) return;
  samples.touch(top, bottom, left, right);
  for (int r = top; r <= bottom; ++r) {
    const float dy = (float(r) + 0.5f - grain.row) * inv, rest = 1.0f - dy * dy;
    for (int c = left; c <= right; c += lanes) {
      Key* to = samples.row(r) + c;
      const float start = (float(c) + 0.5f - grain.column) * inv;
      for (int l = 0; l < lanes; ++l) {  // whole lanes: the compiler turns them into vectors
        const float dx = start + float(l) * inv, square = rest - dx * dx;
        const float depth = grain.depth - grain.radius * std::sqrt(std::max(square, 0.0f));
        const Key key = square >= 0.0f ? make_key(depth, index) : nothing;
        to[l] = std::min(to[l], key);
      }
    }
  }
}

// Whether a bounded solid lies wholly behind the eye or beyond an edge of the film, give or take a hundredth.
inline bool is_beside(const Solid& solid, const Camera& camera) {
  const Vec3f to = solid.middle - camera.eye;
  const float ahead = dot(to, camera.forward), bound = 1.01f * solid.bound + 0.01f * length(to);
  const auto beyond = [&](float off, int pixels) {  // of the planes through the eye and two edges
    const float tangent = 0.5f * float(pixels) / camera.focal;
    return std::abs(off) - tangent * ahead > bound * std::sqrt(1 + tangent * tangent);
  };
  return ahead < -bound || beyond(dot(to, camera.right), camera.width) ||
         beyond(dot(to, camera.down), camera.height);
}

// Where a solid that is no mesh may be seen.
struct OnFilm {
  std::uint32_t solid;
  Vec3f at{};       // column and row of its middle [px], depth [m]
  float wide = -1;  // radius of a disc that holds it [px]; below zero: anywhere
};

// Return the solids that rest, or the others, but no meshes, that may be seen in rows [first, last) of samples.
inline std::vector<OnFilm> on_film(std::span<const Solid> solids, bool is_static, const Camera& camera,
                                   int first, int last) {
  constexpr float pixel = 1.0f / Samples::per_axis;
  const float top = (float(first) + 0.5f) * pixel, bottom = (float(last) - 0.5f) * pixel;
  std::vector<OnFilm> found;
  for (std::uint32_t b = 0; b < solids.size(); ++b) {
    const Solid& solid = solids[b];
    if (solid.is_static != is_static || solid.mesh) continue;
    OnFilm seen{b};
    if (!solid.is_plane()) {
      seen.at = camera.project(solid.place.centre);
      if (is_beside(solid, camera)) continue;
      if (seen.at.z > 2.0f * solid.bound) {  // far enough for its ball to have a width on the film
        seen.wide = 1.2f * camera.focal * solid.bound / (seen.at.z - solid.bound);
        if (seen.at.y + seen.wide < top || seen.at.y - seen.wide > bottom) continue;
      }
    }
    found.push_back(seen);
  }
  return found;
}

// Cast a ray at solids through every sample of a row.
inline void cast_row(Samples& samples, std::span<const Solid> solids, std::span<const OnFilm> seen,
                     const Camera& camera, int r) {
  constexpr float pixel = 1.0f / Samples::per_axis;
  Key* row = samples.row(r);
  const Vec3f start = camera.through(0.5f * pixel, (float(r) + 0.5f) * pixel),
              step = camera.right * (pixel / camera.focal);
  for (const auto& [b, at, wide] : seen) {
    const Solid& solid = solids[b];
    if (solid.is_plane()) {  // one division per sample
      const float height = dot(solid.place.rotation.c2, camera.eye - solid.place.centre),
                  fall = -dot(solid.place.rotation.c2, start);
      const float change = -dot(solid.place.rotation.c2, step);
      if (height <= 0) continue;
      samples.touch(r, r, 0, samples.width - 1);
      for (int c = 0; c < samples.width; ++c) {
        const float down = fall + change * float(c), depth = height / down;
        const Key key = down > 0.0f && depth < 1e20f ? make_key(depth, first_solid + b) : nothing;
        row[c] = std::min(row[c], key);
      }
      continue;
    }
    float left = 0, right = float(samples.width);
    if (wide >= 0) {
      if (std::abs(at.y - (float(r) + 0.5f) * pixel) > wide) continue;
      left = std::clamp((at.x - wide) / pixel, 0.0f, right),
      right = std::clamp((at.x + wide) / pixel, 0.0f, right);
    }
    samples.touch(r, r, int(left), int(right) - 1);
    for (int c = int(left); c < int(right); ++c) {
      const Hit hit = meet(solid, camera.eye, start + step * float(c));
      if (hit.t < 1e20f) row[c] = std::min(row[c], make_key(hit.t, first_solid + b));
    }
  }
}

// Draw the solids that rest, or the others, into rows [first, last).
inline void draw_solids(Samples& samples, std::span<const Solid> solids, bool is_static, const Raster& meshes,
                        const Camera& camera, int first, int last) {
  const std::vector<OnFilm> seen = on_film(solids, is_static, camera, first, last);
  for (int r = first; r < last; ++r) cast_row(samples, solids, seen, camera, r);
  meshes.draw(first, last, Samples::per_axis,
              [&](int r, int c, float depth, std::uint32_t solid, std::uint32_t) {
                samples.touch(r, r, c, c);
                Key& key = samples.row(r)[c];
                key = std::min(key, make_key(depth, first_solid + solid));
              });
}

// Look which cells of rows [first, last), of those that are touched, show a solid.
inline void look_for_solids(Samples& samples, int first, int last) {
  for (int i = first / Samples::cell; i * Samples::cell < last; ++i)
    for (int j = 0; j < samples.cell_columns(); ++j) {
      if (!samples.touched[samples.cell_at(i, j)]) continue;
      bool any = false;
      samples.each_of(i, j, [&](int, int, Key key) { any |= is_solid(key); });
      samples.shows_solid[samples.cell_at(i, j)] = any;
    }
}

// Draw what rests into an empty z-buffer.
inline void draw_still(Samples& samples, std::span<const Solid> solids, const Raster& meshes,
                       const Camera& camera) {
  std::fill(samples.touched.begin(), samples.touched.end(), 1);
#pragma omp parallel for schedule(dynamic)
  for (int b = 0; b < samples.bands(); ++b) {
    const int first = b * Samples::band, last = std::min(first + Samples::band, samples.height);
    std::fill(samples.row(first), samples.row(last - 1) + samples.pitch, nothing);
    draw_solids(samples, solids, true, meshes, camera, first, last);
    look_for_solids(samples, first, last);
  }
}

// Take cells of rows [first, last) that were touched back to what rests.
inline void restore(Samples& samples, const Samples& still, int first, int last) {
  for (int i = first / Samples::cell; i * Samples::cell < last; ++i)
    for (int j = 0; j < samples.cell_columns(); ++j) {
      std::uint8_t& touched = samples.touched[samples.cell_at(i, j)];
      if (!touched) continue;
      for (int r = i * Samples::cell; r < samples.end_row(i); ++r)
        std::copy(still.row(r) + j * Samples::cell, still.row(r) + samples.end_column(j),
                  samples.row(r) + j * Samples::cell);
      samples.shows_solid[samples.cell_at(i, j)] = still.shows_solid[samples.cell_at(i, j)];
      touched = 0;
    }
}

// Draw grains and the solids that do not rest over what does. What nothing has touched since the frame before stays.
inline void draw_samples(Samples& samples, const Samples& still, std::span<const Solid> solids,
                         const Raster& meshes, std::span<const Grain> grains, const Camera& camera) {
  const int bands = samples.bands();
  std::vector<std::vector<std::uint32_t>> in_band(static_cast<std::size_t>(bands));
  for (std::uint32_t g = 0; g < grains.size(); ++g) {
    const float wide = std::max(grains[g].wide, least_radius);
    const float from = (grains[g].row - wide) / Samples::band, to = (grains[g].row + wide) / Samples::band;
    if (!(to >= 0 && from < float(bands))) continue;
    for (int b = std::max(0, int(from)); b <= std::min(bands - 1, int(to)); ++b)
      in_band[std::size_t(b)].push_back(g);
  }
#pragma omp parallel for schedule(dynamic)
  for (int b = 0; b < bands; ++b) {
    const int first = b * Samples::band, last = std::min(first + Samples::band, samples.height);
    restore(samples, still, first, last);
    draw_solids(samples, solids, false, meshes, camera, first, last);
    for (std::uint32_t g : in_band[std::size_t(b)]) splat_grain(samples, grains[g], g, first, last);
    look_for_solids(samples, first, last);
  }
}

}  // namespace neve::render
