// Meshes on the film: which triangle lies in front in each sample. Cheaper than a ray per sample, and exact.
#pragma once

#include <vector>

#include "render/solids/solids.hpp"
#include "render/view/camera.hpp"

namespace neve::render {

// A triangle on the film.
struct Flat {
  double column[3], row[3];  // of its corners [px]
  float inverse[3];          // of depth is inverse[0] + inverse[1] column + inverse[2] row [1/m]
  float near, far;           // depth of its corners [m]
  std::uint32_t solid, triangle;
};

// The triangles of meshes that can be on the film, listed by bands of rows.
class Raster {
 public:
  static constexpr int band = 16;  // pixels

  explicit Raster(const Camera& camera) : camera_(camera) {}

  // is_static: take the meshes that rest, or those that may move.
  Raster(std::span<const Solid> solids, const Camera& camera, bool is_static) : camera_(camera) {
    constexpr std::size_t chunk = 4096;
    struct Part {
      std::uint32_t solid;
      std::size_t first, end;
    };
    std::vector<Part> parts;
    for (std::uint32_t b = 0; b < solids.size(); ++b) {
      if (!solids[b].mesh || solids[b].is_static != is_static) continue;
      const std::size_t n = solids[b].mesh->triangles().size();
      for (std::size_t first = 0; first < n; first += chunk)
        parts.push_back({b, first, std::min(first + chunk, n)});
    }
    std::vector<std::vector<Flat>> flats(parts.size());
#pragma omp parallel for schedule(dynamic)
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (std::size_t t = parts[p].first; t < parts[p].end; ++t)
        project(solids[parts[p].solid], parts[p].solid, std::uint32_t(t), flats[p]);
    in_band_.resize(std::size_t((camera.height + band - 1) / band));
    for (const auto& part : flats) flat_.insert(flat_.end(), part.begin(), part.end());
    for (std::uint32_t f = 0; f < flat_.size(); ++f) {
      const Flat& flat = flat_[f];
      const auto [low, high] = std::minmax({flat.row[0], flat.row[1], flat.row[2]});
      const int last = std::min(int(std::min(high, 1e6) / band), int(in_band_.size()) - 1);
      for (int b = int(std::max(low, 0.0) / band); b <= last; ++b) in_band_[std::size_t(b)].push_back(f);
    }
  }

  bool empty() const { return flat_.empty(); }

  // Call put(row, column, depth, solid, triangle) for each sample in rows [first, last) that a triangle covers;
  // samples lie in the middle of 1/n pixel.
  template <class Put>
  void draw(int first, int last, int n, const Put& put) const {
    if (flat_.empty() || first >= last) return;
    const int from = first / (n * band), to = (last - 1) / (n * band);
    for (int b = from; b <= to; ++b)
      for (std::uint32_t f : in_band_[std::size_t(b)])
        fill(flat_[f], std::max(first, b * n * band), std::min(last, (b + 1) * n * band), n, put);
  }

 private:
  struct Corner {
    double x, y, z;  // right, down, forward of the eye [m]
  };

  void project(const Solid& solid, std::uint32_t b, std::uint32_t t, std::vector<Flat>& out) const {
    const Triangle& triangle = solid.mesh->triangles()[t];
    const Point* corners[3] = {&triangle.a, &triangle.b, &triangle.c};
    Corner seen[4];
    for (int k = 0; k < 3; ++k) {
      const Vec3f d = solid.place.rotation * to_vec(*corners[k]) + (solid.place.centre - camera_.eye);
      seen[k] = {dot(d, camera_.right), dot(d, camera_.down), dot(d, camera_.forward)};
    }
    // Cut off what lies behind the eye or just before it: up to four corners are left.
    const double near = 1e-3 * camera_.reach;
    Corner kept[4];
    int n = 0;
    for (int k = 0; k < 3; ++k) {
      const Corner &p = seen[k], &q = seen[(k + 1) % 3];
      if (p.z >= near) kept[n++] = p;
      if ((p.z >= near) == (q.z >= near)) continue;
      const double s = (near - p.z) / (q.z - p.z);
      kept[n++] = {p.x + s * (q.x - p.x), p.y + s * (q.y - p.y), near};
    }
    for (int k = 2; k < n; ++k) flatten(kept[0], kept[k - 1], kept[k], b, t, out);
  }

  void flatten(const Corner& a, const Corner& b, const Corner& c, std::uint32_t solid, std::uint32_t triangle,
               std::vector<Flat>& out) const {
    Flat flat{};
    const Corner* corners[3] = {&a, &b, &c};
    for (int k = 0; k < 3; ++k) {
      const double scale = camera_.focal / corners[k]->z;
      flat.column[k] = 0.5 * camera_.width + corners[k]->x * scale;
      flat.row[k] = 0.5 * camera_.height + corners[k]->y * scale;
    }
    const auto [left, right] = std::minmax({flat.column[0], flat.column[1], flat.column[2]});
    const auto [top, bottom] = std::minmax({flat.row[0], flat.row[1], flat.row[2]});
    if (right < 0 || bottom < 0 || left > camera_.width || top > camera_.height) return;
    // The plane n . p = n . a in the eye's frame gives 1/z = n . (x/z, y/z, 1) / (n . a).
    const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y,
                 vz = c.z - a.z;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const double height = nx * a.x + ny * a.y + nz * a.z;
    if (std::fabs(height) < 1e-12 * std::sqrt(nx * nx + ny * ny + nz * nz) * camera_.reach)
      return;  // edge on
    const double px = nx / (height * camera_.focal), py = ny / (height * camera_.focal);
    flat.inverse[0] = float(nz / height - 0.5 * (px * camera_.width + py * camera_.height));
    flat.inverse[1] = float(px), flat.inverse[2] = float(py);
    const auto [near, far] = std::minmax({a.z, b.z, c.z});
    flat.near = float(near), flat.far = float(far);
    flat.solid = solid, flat.triangle = triangle;
    out.push_back(flat);
  }

  template <class Put>
  void fill(const Flat& flat, int first, int last, int n, const Put& put) const {
    constexpr double slack =
        1e-3;  // samples on an edge belong to both sides: no gaps, and the nearer one wins
    double x[3], y[3];
    for (int k = 0; k < 3; ++k) x[k] = n * flat.column[k] - 0.5, y[k] = n * flat.row[k] - 0.5;
    const auto [top, bottom] = std::minmax({y[0], y[1], y[2]});
    const int from = whole(std::ceil(top - slack), first, last);
    const int to = whole(std::floor(bottom + slack), first - 1, last - 1);
    const float size = 1.0f / float(n);
    for (int r = from; r <= to; ++r) {
      const auto [left, right] = span(x, y, r, slack);
      const int begin = whole(std::ceil(left - slack), 0, n * camera_.width);
      const int end = whole(std::floor(right + slack), -1, n * camera_.width - 1);
      const float inverse = flat.inverse[0] + flat.inverse[2] * ((float(r) + 0.5f) * size);
      for (int c = begin; c <= end; ++c) {
        const float at = inverse + flat.inverse[1] * ((float(c) + 0.5f) * size);
        put(r, c, at > 0 ? std::clamp(1.0f / at, flat.near, flat.far) : flat.far, flat.solid, flat.triangle);
      }
    }
  }

  // Return where row r enters and leaves the triangle.
  static std::pair<double, double> span(const double* x, const double* y, int r, double slack) {
    double left = 1e9, right = -1e9;
    for (int k = 0; k < 3; ++k) {
      const int m = (k + 1) % 3;
      const auto [low, high] = std::minmax(y[k], y[m]);
      if (r < low - slack || r > high + slack) continue;
      if (high - low < 1e-9) {
        left = std::min({left, x[k], x[m]}), right = std::max({right, x[k], x[m]});
        continue;
      }
      const double at = x[k] + (x[m] - x[k]) * std::clamp((r - y[k]) / (y[m] - y[k]), 0.0, 1.0);
      left = std::min(left, at), right = std::max(right, at);
    }
    return {left, right};
  }

  Camera camera_;
  std::vector<Flat> flat_;
  std::vector<std::vector<std::uint32_t>> in_band_;
};

}  // namespace neve::render
