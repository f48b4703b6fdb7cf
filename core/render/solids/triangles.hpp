// What a picture asks of the triangles of a mesh: normals that are smooth where the surface is, and how closely a ray
// towards the sun passes by.
#pragma once

#include <array>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "render/view/vec.hpp"

namespace neve::render {

inline Point to_point(Vec3f a) { return {a.x, a.y, a.z}; }
inline Vec3f to_vec(const Point& a) { return {float(a.x), float(a.y), float(a.z)}; }

using Corners3 = std::array<Vec3f, 3>;

// Return a normal for each corner of each triangle: the mean of those triangles around the corner that turn away from
// this one by less than the crease angle, weighted by their area. Corners at one place are one corner.
inline std::vector<Corners3> corner_normals(const std::vector<Triangle>& triangles) {
  constexpr double crease =
      0.80;  // cosine of the largest angle between triangles of one smooth surface: 37 degrees
  struct Corner {
    Point at;
    std::uint32_t triangle, corner;
  };
  std::vector<Corner> corners;
  std::vector<Point> unit(triangles.size());
  corners.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle& triangle = triangles[t];
    corners.push_back({triangle.a, t, 0});
    corners.push_back({triangle.b, t, 1});
    corners.push_back({triangle.c, t, 2});
    const Point n = triangle.area_vector();
    unit[t] = n * (1.0 / std::sqrt(dot(n, n)));
  }
  const auto before = [](const Corner& a, const Corner& b) {
    if (a.at.x != b.at.x) return a.at.x < b.at.x;
    if (a.at.y != b.at.y) return a.at.y < b.at.y;
    if (a.at.z != b.at.z) return a.at.z < b.at.z;
    return a.triangle < b.triangle;
  };
  std::sort(corners.begin(), corners.end(), before);
  std::vector<Corners3> normals(triangles.size());
  for (std::size_t first = 0, end = 0; first < corners.size(); first = end) {
    const Point at = corners[first].at;
    while (end < corners.size() && corners[end].at.x == at.x && corners[end].at.y == at.y &&
           corners[end].at.z == at.z)
      ++end;
    for (std::size_t i = first; i < end; ++i) {
      Point sum{};
      for (std::size_t j = first; j < end; ++j)
        if (dot(unit[corners[i].triangle], unit[corners[j].triangle]) >= crease)
          sum = sum + triangles[corners[j].triangle].area_vector();
      normals[corners[i].triangle][corners[i].corner] = to_vec(sum * (1.0 / std::sqrt(dot(sum, sum))));
    }
  }
  return normals;
}

// How closely a ray passes by triangles.
class NearMiss {
 public:
  // direction: of unit length; start: where the ray begins to count [m].
  NearMiss(const TriangleMesh& mesh, Vec3f origin, Vec3f direction, float start)
      : mesh_(mesh),
        ray_(to_point(origin), to_point(direction)),
        origin_(to_point(origin)),
        direction_(to_point(direction)),
        start_(start) {
    const float o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    for (int k = 0; k < 3; ++k) {
      from_[k] = o[k], way_[k] = d[k];
      inverse_[k] = 1.0f / (std::abs(d[k]) > 1e-18f ? d[k] : 1e-18f);
    }
  }

  // Return the least angle [rad, small] between the ray and anything seen from its origin, at most `widest`: zero if
  // the ray meets a triangle or comes closer than a hundredth of that. It is the distance of the nearest miss over
  // the way to it.
  double angle(double widest) {
    best_ = widest;
    struct Waiting {
      std::uint32_t node;
      float enters;
      double best;
    } stack[BvhBuilder::deepest];
    const auto waiting = [&](std::uint32_t node) {
      return Waiting{node, enters(mesh_.nodes()[node]), best_};
    };
    int top = 0;
    stack[top++] = waiting(0);
    while (top > 0) {
      Waiting at = stack[--top];
      const BvhNode& node = mesh_.nodes()[at.node];
      if (at.best != best_) at.enters = enters(node);
      if (at.enters > out) continue;
      if (node.leaf()) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(mesh_.triangles()[i]);
        if (best_ < 0.01 * widest) return 0;
        continue;
      }
      Waiting near = waiting(at.node + 1), far = waiting(node.first);
      if (far.enters < near.enters) std::swap(near, far);
      if (far.enters < out) stack[top++] = far;
      if (near.enters < out) stack[top++] = near;
    }
    return best_;
  }

 private:
  static constexpr float out = 1e30f;

  // Where the ray enters the node's box [m], widened by all that the best angle spans at its far end: a point that
  // is seen closer to the ray lies no farther from it. More than `out` if it does not.
  float enters(const BvhNode& node) const {
    float end = 0;
    for (int k = 0; k < 3; ++k)
      end += std::max((node.low[k] - from_[k]) * way_[k], (node.high[k] - from_[k]) * way_[k]);
    const float wide = float(best_) * end * 1.0001f;
    float near = 0, far = out;
    for (int k = 0; k < 3; ++k) {
      const float a = (node.low[k] - wide - from_[k]) * inverse_[k],
                  b = (node.high[k] + wide - from_[k]) * inverse_[k];
      near = std::max(near, std::min(a, b));
      far = std::min(far, std::max(a, b));
    }
    return end < float(start_) || near > far * 1.00001f ? 2 * out : near;
  }

  void visit(const Triangle& t) {
    Ray::Meeting at;
    if (ray_.meets(t, Bounds::inf, at) && at.t > start_) {
      best_ = 0;
      return;
    }
    pass(t.a, t.b), pass(t.b, t.c), pass(t.c, t.a);
  }

  // Take in the place of an edge that is nearest to the ray's line.
  void pass(const Point& a, const Point& b) {
    const Point to = a - origin_, way = b - a;
    const double along = dot(to, direction_), onward = dot(way, direction_);
    const Point aside = to - direction_ * along, across = way - direction_ * onward;
    const double length2 = dot(across, across);
    const double s = length2 > 0 ? std::clamp(-dot(aside, across) / length2, 0.0, 1.0) : 0.0;
    const double t = along + s * onward;
    if (t <= start_) return;
    const Point miss = aside + across * s;
    const double miss2 = dot(miss, miss);
    if (miss2 < best_ * best_ * t * t) best_ = std::sqrt(miss2) / t;
  }

  const TriangleMesh& mesh_;
  Ray ray_;
  Point origin_, direction_;
  float from_[3], way_[3], inverse_[3];
  double start_, best_ = 0;
};

}  // namespace neve::render
