// One triangle: the point of it nearest to another, the angle under which it is seen, where a ray meets it. In double.
#pragma once

#include <cmath>
#include <limits>

#include "math/mat3.hpp"

namespace neve {

using Point = Vec3<double>;

struct Triangle {
  Point a, b, c;

  Point area_vector() const { return cross(b - a, c - a) * 0.5; }  // along the outward normal [m2]
  Point middle() const { return (a + b + c) * (1.0 / 3.0); }
};

namespace detail {

inline Point nearest_on_edge(const Point& p, const Point& q, const Point& x) {
  const Point along = q - p;
  const double length2 = dot(along, along);
  const double t = length2 > 0 ? dot(x - p, along) / length2 : 0.0;
  return p + along * std::fmin(std::fmax(t, 0.0), 1.0);
}

}  // namespace detail

// The point of the triangle nearest to x: the foot of the perpendicular if it falls inside all three edges, otherwise
// the nearest point of an edge that it falls outside of.
inline Point nearest_on(const Triangle& t, const Point& x) {
  const Point n = cross(t.b - t.a, t.c - t.a);
  const Point corner[3] = {t.a, t.b, t.c};
  Point best{};
  double best2 = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Point &p = corner[k], &q = corner[(k + 1) % 3];
    if (dot(cross(n, q - p), x - p) >= 0) continue;
    const Point at = detail::nearest_on_edge(p, q, x);
    const double d2 = dot(x - at, x - at);
    if (d2 < best2) best2 = d2, best = at;
  }
  if (best2 < std::numeric_limits<double>::infinity()) return best;
  return x - n * (dot(n, x - t.a) / dot(n, n));
}

// The signed solid angles of triangles, added up: positive where a triangle turns its back to the point.
//
// Half the angle of a triangle is the argument of a complex number (Van Oosterom and Strackee 1983, equation 8), so the
// sum is the argument of the product, and full turns are counted as they happen: no inverse tangent per triangle.
class SolidAngle {
 public:
  void add(const Triangle& t, const Point& x) {
    const Point a = t.a - x, b = t.b - x, c = t.c - x;
    const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
    const double scale = la * lb * lc;
    if (!(scale > 0)) return;  // x is a corner: the angle is anything
    const double inv = 1.0 / scale;
    const double im = dot(a, cross(b, c)) * inv;
    const double re = 1.0 + (dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb) * inv;
    if (im == 0.0 && re == 0.0) return;  // x is on an edge
    const double next_re = re_ * re - im_ * im, next_im = re_ * im + im_ * re;
    if (im_ >= 0 && im >= 0 && next_im < 0) ++turns_;
    if (im_ < 0 && im < 0 && next_im >= 0) --turns_;
    const double size = std::fmax(std::fabs(next_re), std::fabs(next_im));
    if (!(size > 0)) return;
    re_ = next_re / size, im_ = next_im / size;
  }
  // The sum over a full sphere's 4 pi [1].
  double winding() const {
    return turns_ + std::atan2(im_, re_) * (0.5 / 3.141592653589793238462643383279503);
  }

 private:
  double re_ = 1, im_ = 0;
  int turns_ = 0;
};

// A ray turned and sheared so that it runs along its own z, which makes meeting a triangle a question in the plane.
//
// Source: Woop, Benthin and Wald 2013, Watertight ray/triangle intersection, sections 3.1 to 3.3. Neighbours that share
// the corners of an edge judge it by the same numbers, so no ray slips between them.
class Ray {
 public:
  Ray(const Point& origin, const Point& direction) : origin_(origin) {
    const double size[3] = {std::fabs(direction.x), std::fabs(direction.y), std::fabs(direction.z)};
    z_ = size[0] > size[1] ? (size[0] > size[2] ? 0 : 2) : (size[1] > size[2] ? 1 : 2);
    x_ = (z_ + 1) % 3, y_ = (z_ + 2) % 3;
    inv_z_ = 1.0 / direction[z_];
    shear_x_ = direction[x_] * inv_z_, shear_y_ = direction[y_] * inv_z_;
    for (int k = 0; k < 3; ++k) inverse_[k] = size[k] > 1e-300 ? 1.0 / direction[k] : 1e300;
  }

  struct Meeting {
    double t;     // in lengths of the direction
    double u, v;  // the point is a + u (b - a) + v (c - a)
  };

  // Whether the ray meets the triangle, edges included, at 0 < t < `most`.
  bool meets(const Triangle& triangle, double most, Meeting& out) const {
    const Point a = sheared(triangle.a), b = sheared(triangle.b), c = sheared(triangle.c);
    const double u = difference(c.x, b.y, c.y, b.x), v = difference(a.x, c.y, a.y, c.x),
                 w = difference(b.x, a.y, b.y, a.x);
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double sum = u + v + w;
    if (sum == 0) return false;
    const double t = (u * a.z + v * b.z + w * c.z) / sum;
    if (!(t > 0 && t < most)) return false;
    out = {t, v / sum, w / sum};
    return true;
  }

  // Where the ray enters a box, in lengths of the direction; infinite if it misses the box or enters behind `most`.
  double enters(const float* low, const float* high, double most) const {
    double near = 0, far = most;
    for (int k = 0; k < 3; ++k) {
      const double a = (low[k] - origin_[k]) * inverse_[k], b = (high[k] - origin_[k]) * inverse_[k];
      near = max(near, min(a, b));
      far = min(far, max(a, b));
    }
    return near <= far * (1 + 1e-14) ? near : std::numeric_limits<double>::infinity();
  }

 private:
  Point sheared(const Point& p) const {
    const Point q = p - origin_;
    return {q[x_] - shear_x_ * q[z_], q[y_] - shear_y_ * q[z_], q[z_] * inv_z_};
  }
  // a b - c d with the right sign (Kahan's product with a fused remainder): both sides of an edge agree.
  static double difference(double a, double b, double c, double d) {
    const double cd = c * d;
    return std::fma(a, b, -cd) + std::fma(-c, d, cd);
  }

  Point origin_, inverse_{};
  int x_ = 0, y_ = 1, z_ = 2;
  double inv_z_ = 1, shear_x_ = 0, shear_y_ = 0;
};

}  // namespace neve
