// A body of triangles: nearest point, rays, and how often it winds around a point.
#pragma once

#include <stdexcept>

#include "geometry/bvh.hpp"
#include "geometry/edges.hpp"
#include "geometry/winding.hpp"

namespace neve {

// Triangles in any order, closed or not, with or without shared corners. Those of no area are passed over; a body that
// is turned inside out (its volume counts negative) is turned back.
class TriangleMesh {
 public:
  struct Nearest {
    Point point{};
    double distance2 = std::numeric_limits<double>::infinity();  // [m2]
    std::uint32_t triangle = none;                               // in the tree's order
    double distance() const { return std::sqrt(distance2); }
  };
  struct RayHit {
    double t = std::numeric_limits<double>::infinity();  // in lengths of the direction
    double u = 0, v = 0;                                 // the point is a + u (b - a) + v (c - a)
    std::uint32_t triangle = none;
    explicit operator bool() const { return triangle != none; }
  };
  static constexpr std::uint32_t none = 0xffffffffu;

  // Errors: std::invalid_argument for a number that is not finite, a corner that is not there, or no area at all.
  TriangleMesh(const std::vector<Point>& vertices, const std::vector<std::array<std::int32_t, 3>>& faces) {
    check(vertices, faces);
    std::vector<Triangle> triangles;
    std::vector<std::int32_t> ids;
    std::vector<Bounds> boxes;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const auto corner = [&](int k) { return vertices[std::size_t(faces[f][k])]; };
      const Triangle t{corner(0), corner(1), corner(2)};
      if (!has_area(t)) continue;
      triangles.push_back(t);
      ids.push_back(std::int32_t(f));
      Bounds& box = boxes.emplace_back();
      box.add(t.a), box.add(t.b), box.add(t.c);
      bounds_.add(box);
    }
    if (triangles.empty()) throw std::invalid_argument("the mesh has no triangle with an area");
    skipped_ = faces.size() - triangles.size();
    closed_ = is_closed(vertices, faces);
    BvhBuilder tree(boxes);
    nodes_ = std::move(tree.nodes);
    for (std::uint32_t i : tree.order) triangles_.push_back(triangles[i]), ids_.push_back(ids[i]);
    measure();
    winding_ = WindingTree(nodes_, triangles_);
  }

  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<BvhNode>& nodes() const { return nodes_; }
  const Bounds& bounds() const { return bounds_; }
  double area() const { return area_; }        // [m2]
  double volume() const { return volume_; }    // [m3], not below zero; of an open mesh a guess
  bool inverted() const { return inverted_; }  // whether all triangles were turned
  bool closed() const { return closed_; }      // whether it winds a whole number of times around every point
  std::size_t skipped() const { return skipped_; }  // triangles without area
  // The number of a triangle of the tree among the faces given.
  std::int32_t face(std::uint32_t triangle) const { return triangle == none ? -1 : ids_[triangle]; }

  // The point of the surface nearest to x, if one is nearer than `within` [m].
  Nearest nearest(const Point& x, double within = std::numeric_limits<double>::infinity()) const {
    Nearest best;
    best.distance2 = within * within;
    struct Waiting {
      std::uint32_t node;
      double distance2;
    } stack[BvhBuilder::deepest];
    int top = 0;
    stack[top++] = {0, nodes_[0].distance2(x)};
    while (top > 0) {
      const Waiting at = stack[--top];
      if (at.distance2 >= best.distance2) continue;
      const BvhNode& node = nodes_[at.node];
      if (node.leaf()) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
          const Point p = nearest_on(triangles_[i], x);
          const double d2 = dot(x - p, x - p);
          if (d2 < best.distance2) best = {p, d2, i};
        }
        continue;
      }
      Waiting near{at.node + 1, nodes_[at.node + 1].distance2(x)};
      Waiting far{node.first, nodes_[node.first].distance2(x)};
      if (far.distance2 < near.distance2) std::swap(near, far);
      stack[top++] = far;
      stack[top++] = near;
    }
    return best;
  }

  // The first triangle that a ray meets at 0 < t < `most`, from either side.
  RayHit ray(const Point& origin, const Point& direction, double most = Bounds::inf) const {
    RayHit hit;
    hit.t = most;
    walk(Ray(origin, direction), hit, [](const RayHit&) { return false; });
    return hit;
  }
  // Whether a ray meets any triangle at 0 < t < `most`.
  bool blocked(const Point& origin, const Point& direction, double most = Bounds::inf) const {
    RayHit hit;
    hit.t = most;
    walk(Ray(origin, direction), hit, [](const RayHit&) { return true; });
    return bool(hit);
  }

  // How often the surface winds around x: 1 inside, 0 outside, something between where it is open.
  double winding(const Point& x) const { return winding_.at(x, nodes_, triangles_); }
  double exact_winding(const Point& x) const {
    SolidAngle sum;
    for (const Triangle& t : triangles_) sum.add(t, x);
    return sum.winding();
  }
  // Inside is where the surface winds around more than half a time, whichever way a part of it is turned.
  static bool winds(double winding) { return std::fabs(winding) > 0.5; }
  double signed_distance(const Point& x) const {
    const double d = nearest(x).distance();
    return winds(winding(x)) ? -d : d;
  }

 private:
  static void check(const std::vector<Point>& vertices,
                    const std::vector<std::array<std::int32_t, 3>>& faces) {
    for (const Point& p : vertices) {
      const double sum = std::fabs(p.x) + std::fabs(p.y) + std::fabs(p.z);
      if (!(sum <= 1e30)) throw std::invalid_argument("a vertex of the mesh is not finite");
    }
    for (const auto& face : faces) {
      for (std::int32_t i : face) {
        if (i < 0 || std::size_t(i) >= vertices.size())
          throw std::invalid_argument("a face of the mesh names a vertex that is not there");
      }
    }
  }

  // Whether the height of a triangle over its longest side is more than rounding.
  static bool has_area(const Triangle& t) {
    const Point ab = t.b - t.a, bc = t.c - t.b, ca = t.a - t.c, n = t.area_vector();
    const double longest2 = std::max({dot(ab, ab), dot(bc, bc), dot(ca, ca)});
    return std::sqrt(dot(n, n)) > 1e-14 * longest2;
  }

  void measure() {
    const Point middle = bounds_.middle();
    for (const Triangle& t : triangles_) {
      const Point n = t.area_vector();
      area_ += std::sqrt(dot(n, n));
      volume_ += dot(n, t.a - middle) / 3.0;
    }
    inverted_ = volume_ < -1e-12 * area_ * std::sqrt(area_);
    volume_ = std::fabs(volume_);
    if (!inverted_) return;
    for (Triangle& t : triangles_) std::swap(t.b, t.c);
  }

  // Visit the triangles that the ray may meet, near before far, until one suffices.
  template <class Enough>
  void walk(const Ray& ray, RayHit& hit, Enough&& enough) const {
    struct Waiting {
      std::uint32_t node;
      double t;
    } stack[BvhBuilder::deepest];
    const auto entry = [&](std::uint32_t n) { return ray.enters(nodes_[n].low, nodes_[n].high, hit.t); };
    int top = 0;
    stack[top++] = {0, entry(0)};
    while (top > 0) {
      const Waiting at = stack[--top];
      if (!(at.t < hit.t)) continue;
      const BvhNode& node = nodes_[at.node];
      if (node.leaf()) {
        Ray::Meeting m;
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
          if (!ray.meets(triangles_[i], hit.t, m)) continue;
          hit = {m.t, m.u, m.v, i};
          if (enough(hit)) return;
        }
        continue;
      }
      Waiting near{at.node + 1, entry(at.node + 1)}, far{node.first, entry(node.first)};
      if (far.t < near.t) std::swap(near, far);
      if (far.t < hit.t) stack[top++] = far;
      if (near.t < hit.t) stack[top++] = near;
    }
  }

  std::vector<Triangle> triangles_;  // in the tree's order
  std::vector<std::int32_t> ids_;
  std::vector<BvhNode> nodes_;
  WindingTree winding_;
  Bounds bounds_;
  double area_ = 0, volume_ = 0;
  bool inverted_ = false, closed_ = false;
  std::size_t skipped_ = 0;
};

}  // namespace neve
