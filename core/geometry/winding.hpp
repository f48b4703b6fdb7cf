// The generalised winding number of triangles, near ones one by one, far ones together.
//
// w(x) = 1 / (4 pi) sum of the solid angles of all triangles seen from x (Jacobson, Kavan and Sorkine-Hornung 2013,
// section 4). Far triangles count as one dipole and its first moment (Barill, Dickson, Schmidt, Levin and Jacobson
// 2018, Fast winding numbers for soups and clouds, section 3): with r from x to their middle,
//   4 pi w = sum_j N_j r_j / r^3 + sum_ij M_ij (delta_ij / r^3 - 3 r_i r_j / r^5),
//   N = sum of area vectors, M = sum over triangles of (their middle - the common middle) times the area vector.
#pragma once

#include "geometry/bvh.hpp"

namespace neve {

class WindingTree {
 public:
  // A node counts as far beyond this many of its radii. What the series leaves out is of the order of (1 / far)^2 of a
  // node's own; the tests hold the sum within 0.03 of the exact one, of which 0.5 decides.
  static constexpr double far = 3;

  WindingTree() = default;
  WindingTree(const std::vector<BvhNode>& nodes, const std::vector<Triangle>& triangles)
      : far_(nodes.size()) {
    for (std::size_t n = 0; n < nodes.size(); ++n) far_[n] = of(nodes, triangles, n);
  }

  double at(const Point& x, const std::vector<BvhNode>& nodes, const std::vector<Triangle>& triangles) const {
    SolidAngle near;
    double sum = 0;
    std::uint32_t stack[BvhBuilder::deepest];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const std::uint32_t n = stack[--top];
      const Moments& m = far_[n];
      const Point r = m.middle - x;
      const double r2 = dot(r, r);
      if (r2 > m.reach2) {
        sum += m.seen_along(r, r2);
      } else if (nodes[n].leaf()) {
        for (std::uint32_t i = nodes[n].first; i < nodes[n].first + nodes[n].count; ++i)
          near.add(triangles[i], x);
      } else {
        stack[top++] = nodes[n].first;
        stack[top++] = n + 1;
      }
    }
    return near.winding() + sum * (0.25 / 3.141592653589793238462643383279503);
  }

 private:
  struct Moments {
    Point middle;   // of the area
    double reach2;  // beyond this squared distance the node counts as far
    Point N;
    Sym3<double> M;  // its symmetric part, which is all that counts

    double seen_along(const Point& r, double r2) const {
      const double inv2 = 1.0 / r2, inv3 = inv2 / std::sqrt(r2);
      const Point Mr{M.xx * r.x + M.xy * r.y + M.xz * r.z, M.xy * r.x + M.yy * r.y + M.yz * r.z,
                     M.xz * r.x + M.yz * r.y + M.zz * r.z};
      return inv3 * (dot(N, r) + M.xx + M.yy + M.zz - 3.0 * inv2 * dot(r, Mr));
    }
  };

  // The triangles below a node are one run: from the first of its leftmost leaf to the last of its rightmost.
  static Moments of(const std::vector<BvhNode>& nodes, const std::vector<Triangle>& triangles,
                    std::size_t n) {
    std::size_t first = n, last = n;
    while (!nodes[first].leaf()) ++first;
    while (!nodes[last].leaf()) last = nodes[last].first;
    const std::uint32_t begin = nodes[first].first, end = nodes[last].first + nodes[last].count;
    Moments m{};
    double area = 0;
    for (std::uint32_t i = begin; i < end; ++i) {
      const Point a = triangles[i].area_vector();
      const double size = std::sqrt(dot(a, a));
      area += size;
      m.N = m.N + a;
      m.middle = m.middle + triangles[i].middle() * size;
    }
    m.middle = m.middle * (1.0 / area);
    for (std::uint32_t i = begin; i < end; ++i) {
      const Triangle& t = triangles[i];
      const Point a = t.area_vector(), d = t.middle() - m.middle;
      m.M.xx += d.x * a.x, m.M.yy += d.y * a.y, m.M.zz += d.z * a.z;
      m.M.xy += 0.5 * (d.x * a.y + d.y * a.x);
      m.M.xz += 0.5 * (d.x * a.z + d.z * a.x);
      m.M.yz += 0.5 * (d.y * a.z + d.z * a.y);
      for (const Point& p : {t.a, t.b, t.c}) m.reach2 = std::max(m.reach2, dot(p - m.middle, p - m.middle));
    }
    m.reach2 *= far * far;
    return m;
  }

  std::vector<Moments> far_;
};

}  // namespace neve
