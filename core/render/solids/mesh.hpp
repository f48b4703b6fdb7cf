// A mesh or a terrain as the picture needs it, in its own frame.
#pragma once

#include <memory>
#include <span>

#include "geometry/height_field.hpp"
#include "render/solids/triangles.hpp"
#include "threads.hpp"

namespace neve::render {

// Rough distances around a mesh, for the shade it gives to what is near: a few dozen samples along its longest side.
class RoughDistance {
 public:
  RoughDistance() = default;
  explicit RoughDistance(const TriangleMesh& mesh) {
    const Bounds& b = mesh.bounds();
    const Vec3f size = to_vec(b.high - b.low);
    const float margin = 0.4f * length(size);
    step_ = (std::max({size.x, size.y, size.z}) + 2 * margin) / 40.0f;
    low_ = to_vec(b.low) - Vec3f{margin, margin, margin};
    const auto count = [&](float side) { return int((side + 2 * margin) / step_) + 2; };
    nx_ = count(size.x), ny_ = count(size.y), nz_ = count(size.z);
    value_.resize(std::size_t(nx_) * std::size_t(ny_) * std::size_t(nz_));
#pragma omp parallel for schedule(dynamic, 4)
    for (int r = 0; r < nx_ * ny_; ++r) {
      double far = Bounds::inf;  // of the sample before from the surface [m]
      float side = 1;
      for (int k = 0; k < nz_; ++k) {
        const Point p = to_point(low_ + Vec3f{float(r / ny_), float(r % ny_), float(k)} * step_);
        // No farther than a step more than before; and on the same side if a step does not reach the surface.
        const bool near = far < 1.001 * step_ || k == 0;
        far = mesh.nearest(p, far + 1.001 * step_).distance();
        if (near) side = TriangleMesh::winds(mesh.winding(p)) ? -1.0f : 1.0f;
        value_[std::size_t(r) * std::size_t(nz_) + std::size_t(k)] = side * float(far);
      }
    }
  }

  float at(Vec3f p) const {
    const Vec3f q = (p - low_) * (1.0f / step_);
    const Vec3f c{std::clamp(q.x, 0.0f, float(nx_) - 1.001f), std::clamp(q.y, 0.0f, float(ny_) - 1.001f),
                  std::clamp(q.z, 0.0f, float(nz_) - 1.001f)};
    const int i = int(c.x), j = int(c.y), k = int(c.z);
    const float a = c.x - float(i), b = c.y - float(j), d = c.z - float(k);
    const auto edge = [&](int di, int dj) {
      const float* v =
          &value_[(std::size_t(i + di) * std::size_t(ny_) + std::size_t(j + dj)) * std::size_t(nz_) +
                  std::size_t(k)];
      return mix(v[0], v[1], d);
    };
    return mix(mix(edge(0, 0), edge(0, 1), b), mix(edge(1, 0), edge(1, 1), b), a) + step_ * length(q - c);
  }

 private:
  Vec3f low_{};
  float step_ = 1;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<float> value_;
};

// Angle by which a ray clears the ground [rad], at most `widest`; the first cell's own ground does not count.
inline float clearance(const HeightField& field, Vec3f p, Vec3f d, float start, float widest) {
  const HeightView& ground = field.view();
  const float cell = float(std::min(ground.size_x / (ground.nx - 1), ground.size_y / (ground.ny - 1)));
  float least = widest, t = std::max(start, cell);
  for (int step = 0; step < 400 && least > 0; ++step) {
    const Vec3f q = p + d * t;
    if (q.z > float(field.high()) && d.z >= 0) break;
    const float away = ground.at(q).phi;
    least = std::min(least, away / t);
    t += std::max(0.7f * away, 0.5f * cell);
  }
  return std::max(least, 0.0f);
}

// Where a ray meets what is drawn.
struct Hit {
  float t = 1e30f;  // in lengths of the direction
  Vec3f normal{};   // against the ray
  Vec3f lift{};     // from the point met to where a shadow ray may start [m]: off the triangles of a mesh
  bool operator==(const Hit&) const = default;
};

class Mesh {
 public:
  // Errors: std::invalid_argument as of TriangleMesh.
  Mesh(const std::vector<Point>& vertices, const std::vector<std::array<std::int32_t, 3>>& faces)
      : mesh_(vertices, faces), normal_(corner_normals(mesh_.triangles())), rough_(mesh_) {
    const Bounds& b = mesh_.bounds();
    middle_ = to_vec(b.middle());
    bound_ = 0.5f * length(to_vec(b.high - b.low));
    shade_ = bound_;
  }
  // A terrain: drawn from at most `most` heights a side, and on to the horizon.
  explicit Mesh(std::unique_ptr<const HeightField> terrain) : Mesh(faces_of(terrain->view())) {
    shade_ = 0.04f * float(std::max(terrain->view().size_x, terrain->view().size_y));
    terrain_ = std::move(terrain);
    rough_ = {};
    bound_ = 1e30f;
  }

  const std::vector<Triangle>& triangles() const { return mesh_.triangles(); }
  Vec3f middle() const { return middle_; }
  float bound() const { return bound_; }  // radius of a ball around the middle that holds the mesh [m]
  float shade() const { return shade_; }  // how far it reaches to hide the sky from what is near [m]

  // Meet the nearest triangle from either side.
  Hit meet(Vec3f p, Vec3f d) const {
    const TriangleMesh::RayHit hit = mesh_.ray(to_point(p), to_point(d));
    return hit ? at(hit.triangle, float(hit.t), float(hit.u), float(hit.v), d) : Hit{};
  }
  // Meet a triangle that is known to lie on the ray, give or take a rounding.
  Hit meet(std::uint32_t triangle, Vec3f p, Vec3f d) const {
    const Triangle& t = mesh_.triangles()[triangle];
    const Point n = cross(t.b - t.a, t.c - t.a), o = to_point(p), w = to_point(d);
    const double fall = dot(n, w), area2 = dot(n, n);
    if (std::fabs(fall) < 1e-30) return {};
    const double way = dot(n, t.a - o) / fall;
    const Point q = o + w * way;
    const double u = dot(n, cross(t.a - t.c, q - t.c)) / area2, v = dot(n, cross(t.b - t.a, q - t.a)) / area2;
    return at(triangle, float(way), float(u), float(v), d);
  }

  // Meet the nearest of these triangles.
  Hit meet(std::span<const std::uint32_t> triangles, Vec3f p, Vec3f d) const {
    const Ray ray(to_point(p), to_point(d));
    Ray::Meeting nearest{1e30, 0, 0}, m;
    Hit hit;
    for (std::uint32_t triangle : triangles)
      if (ray.meets(mesh_.triangles()[triangle], nearest.t, m)) {
        nearest = m;
        hit = at(triangle, float(m.t), float(m.u), float(m.v), d);
      }
    return hit;
  }

  // Rough signed distance [m].
  float distance(Vec3f p) const { return terrain_ ? terrain_->view().at(p).phi : rough_.at(p); }
  // Distance to the surface [m], or `within` if that is shorter: exact where it is asked for near, else rough. A
  // little less than `within` is looked through and stretched: then the surface on which one stands is passed over.
  float nearest(Vec3f p, float within) const {
    if (terrain_ || within > 0.1f * shade_) return std::clamp(distance(p), 0.0f, within);
    constexpr float part = 0.97f;
    return float(mesh_.nearest(to_point(p), part * within).distance()) / part;
  }
  // Angle between the ray and the nearest miss [rad], zero for a hit, at most `widest`.
  float miss(Vec3f p, Vec3f unit_direction, float start, float widest) const {
    if (terrain_) return clearance(*terrain_, p, unit_direction, start, widest);
    return float(NearMiss(mesh_, p, unit_direction, start).angle(widest));
  }

 private:
  // The hit on a triangle at p = a + u (b - a) + v (c - a).
  Hit at(std::uint32_t triangle, float t, float u, float v, Vec3f d) const {
    const Triangle& corner = mesh_.triangles()[triangle];
    const Corners3& n = normal_[triangle];
    const Vec3f a = to_vec(corner.a), b = to_vec(corner.b), c = to_vec(corner.c);
    const float w = 1.0f - u - v;
    const Vec3f p = a * w + b * u + c * v;
    const Vec3f face = normalize(cross(b - a, c - a));
    const float side = dot(face, d) > 0 ? -1.0f : 1.0f;
    // Start shadow rays from the round surface that the corners' normals mean, not from the flat triangle:
    // project p onto the corners' tangent planes (Boubekeur & Alexa 2008, Phong tessellation, section 3).
    const auto rise = [&](Vec3f corner_at, Vec3f normal) {
      return normal * std::max(-side * dot(p - corner_at, normal), 0.0f) * side;
    };
    const Vec3f lift =
        rise(a, n[0]) * w + rise(b, n[1]) * u + rise(c, n[2]) * v + face * (side * 2e-4f * shade_);
    return {t, normalize(n[0] * w + n[1] * u + n[2] * v) * side, lift};
  }

  struct Faces {
    std::vector<Point> vertices;
    std::vector<std::array<std::int32_t, 3>> faces;
  };
  explicit Mesh(const Faces& s) : mesh_(s.vertices, s.faces), normal_(corner_normals(mesh_.triangles())) {
    middle_ = to_vec(mesh_.bounds().middle());
  }

  // Triangles of the ground. More heights than a side of `most` would not show: every other one is left out.
  static Faces faces_of(const HeightView& h) {
    constexpr int most = 500;
    const auto places = [](int n, double length) {
      const float size = float(length);
      std::vector<std::pair<int, float>> out{{0, -30.0f * size}};
      const int stride = (n - 1) / most + 1;
      for (int i = 0; i < n - 1; i += stride) out.emplace_back(i, size * (float(i) / float(n - 1) - 0.5f));
      out.emplace_back(n - 1, 0.5f * size);
      out.emplace_back(n - 1, 30.0f * size);
      return out;
    };
    const auto xs = places(h.nx, h.size_x), ys = places(h.ny, h.size_y);
    Faces s;
    for (const auto& [i, x] : xs)
      for (const auto& [j, y] : ys) s.vertices.push_back({x, y, h.height(i, j)});
    const auto n = std::int32_t(ys.size());
    for (std::int32_t i = 0; i + 1 < std::int32_t(xs.size()); ++i)
      for (std::int32_t j = 0; j + 1 < n; ++j) {
        const std::int32_t a = i * n + j;
        s.faces.push_back({a, a + n, a + n + 1});
        s.faces.push_back({a, a + n + 1, a + 1});
      }
    return s;
  }

  TriangleMesh mesh_;
  std::vector<Corners3> normal_;  // of the corners, as the triangles are
  RoughDistance rough_;
  std::unique_ptr<const HeightField> terrain_;  // none of other meshes
  Vec3f middle_{};
  float bound_ = 1, shade_ = 1;
};

}  // namespace neve::render
