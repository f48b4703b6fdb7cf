// The signed distance of a solid of any shape, on a grid in its own frame: what is asked of it.
//
// Near the surface there are bricks of 8^3 cells; elsewhere only the bricks' corners have values. A value is a quad of
// floats: phi and the three parts of the unit normal, so that a point asks for eight neighbouring quads and gets both.
#pragma once

#include "geometry/quads.hpp"
#include "geometry/surface.hpp"
#include "math/standard.hpp"

namespace neve {

// Where the samples lie.
struct SdfLattice {
  static constexpr int cells = 8, side = cells + 1;                    // of a brick; samples on its side
  static constexpr std::size_t brick_floats = 4 * side * side * side;  // 11.4 KiB
  static constexpr std::int32_t coarse_only = -1;
  // A gradient of phi below this, or a blend of normals, is none: the normals around it are of two sides.
  static constexpr double least_slope = 0.5;

  Vec3<double> box_low{};              // the first corner of the grid [m]
  double spacing = 1;                  // of the samples in bricks [m]
  double band = 0;                     // there are bricks wherever |phi| is no more [m]
  Vec3<double> low{}, high{};          // the solid's own bounds [m]
  std::int32_t bricks[3] = {1, 1, 1};  // along each axis
};

// A grid whose samples another owns.
struct SdfView : SdfLattice {
  const std::int32_t* table = nullptr;  // brick -> its place in `fine`, or coarse_only
  const float *coarse = nullptr,
              *fine = nullptr;  // quads: at the corners of bricks; 9^3 per brick; z runs fastest

  // phi and normal at points in the body's frame. Within the grid: trilinear, the normal made a unit again, or where
  // normals cancel that of the nearest sample. Beyond it: from the point of the surface that belongs to the grid's
  // nearest point, which is no less than the distance.
  // Lanes that are not of the mask `wanted` mean nothing.
  template <class R, class M>
  Surface<R> at(const Vec3<R>& x, const M& wanted) const {
    using T = scalar_t<R>;
    Vec3<R> cell, beyond;
    locate(x, cell, beyond);
    auto [phi, n] = blended(cell, wanted);
    const auto cancel = wanted & (dot(n, n) < splat<R>(T(least_slope * least_slope)));
    if (any(cancel)) {
      const R half = splat<R>(T(0.5));
      const Vec3<R> nearest{floor(cell.x + half), floor(cell.y + half), floor(cell.z + half)};
      n = select(cancel, blended(nearest, cancel).normal, n);
    }
    n = unit(n);
    const auto out = dot(beyond, beyond) > R{};
    if (any(out)) {
      const Vec3<R> away = n * phi + beyond;
      phi = select(out, sqrt(dot(away, away)), phi);
      n = select(out, unit(away), n);
    }
    return {phi, n};
  }

  template <class R>
  Surface<R> at(const Vec3<R>& x) const {
    return at(x, R{} == R{});
  }

  // A number that the distance of x, and what `at` says of it, do not fall below [m]: phi at the nearest sample, less how far
  // that is, and less what blends of samples may be off by. Without a brick all is inside, or farther than the band. Beyond
  // the grid: the distance from the solid's bounds.
  double least(const Vec3<double>& x) const {
    Vec3<double> cell, beyond, apart;
    locate(x, cell, beyond);
    for (int k = 0; k < 3; ++k) apart[k] = max(max(low[k] - x[k], x[k] - high[k]), 0.0);
    const double outside = sqrt(dot(apart, apart));
    if (dot(beyond, beyond) > 0) return outside;
    const Nearest<double> near = nearest(cell.x, cell.y, cell.z);
    // a blend is off by no more than half a diagonal: it is a mean over the corners of a cell
    const double off = spacing * (near.cells * sqrt(near.away2) + 0.8661);
    if (near.cells == 1) return max(outside, near.phi - off);
    return near.phi <= 0 ? -double(std::numeric_limits<float>::max())
                         : max(outside, max(band, near.phi - off));
  }

  // A number that what `at` says of points in the body's frame does not fall below [m]. `at` blends the corners of a cell by
  // weights w; a corner is |c - c_n| from the nearest one, so that it has phi_n less this at least, and the mean of a root is
  // at most the root of the mean: sum w |c - c_n| <= sqrt(sum_k f_k), with f_k the way to c_n along axis k, in cells.
  // Lanes that are not of the mask `wanted` mean nothing.
  template <class R, class M>
  R least_at(const Vec3<R>& x, const M& wanted) const {
    using T = scalar_t<R>;
    Vec3<R> cell, beyond;
    locate(x, cell, beyond);
    Vec3<R> brick, up;
    R along{}, sample{}, size = splat<R>(1);
    for (int k = 0; k < 3; ++k) {
      const R first = floor(min(cell[k], splat<R>(T(cells * bricks[k] - 1)))), f = cell[k] - first;
      brick[k] = floor(first * T(1.0 / cells));
      up[k] = select(f > splat<R>(T(0.5)), splat<R>(1), R{});
      along = along + abs(f - up[k]);
      sample = sample * T(side) + (first - brick[k] * T(cells) + up[k]);
    }
    R phi{};
    for_lanes(wanted, [&](int l) {
      const auto b = [&](int k) { return std::size_t(int(detail::lane(brick[k], l))); };
      const std::int32_t found =
          table[(b(0) * std::size_t(bricks[1]) + b(1)) * std::size_t(bricks[2]) + b(2)];
      if (found != coarse_only) {
        const auto at = std::size_t(4 * int(detail::lane(sample, l)));
        return detail::set_lane(phi, l, T(fine[std::size_t(found) * brick_floats + at]));
      }
      const Nearest<T> near =
          nearest(detail::lane(cell.x, l), detail::lane(cell.y, l), detail::lane(cell.z, l));
      // where all is inside
      detail::set_lane(phi, l, near.phi <= 0 ? -std::numeric_limits<T>::max() : T(near.phi));
      detail::set_lane(along, l, near.along), detail::set_lane(size, l, T(cells));
    });
    // a little more, for the rounding of places
    const R inside = phi - size * (sqrt(along) + T(0.01)) * T(spacing);
    const R out2 = dot(beyond, beyond);
    return select(out2 > R{}, sqrt(out2) * T(0.999), inside);
  }

  // Whether the surface or the inside may be within `reach` [m] of x; false only if it is not.
  bool is_near(const Vec3<double>& x, double reach) const { return least(x) <= reach; }

 private:
  // Points in cells from the grid's first corner, those outside moved to its nearest point; and by how much [m].
  template <class R>
  void locate(const Vec3<R>& x, Vec3<R>& cell, Vec3<R>& beyond) const {
    using T = scalar_t<R>;
    const T inv = T(1 / spacing);
    for (int k = 0; k < 3; ++k) {
      const R u = (x[k] - T(box_low[k])) * inv;
      cell[k] = clamp(u, R{}, splat<R>(T(cells * bricks[k])));
      beyond[k] = (u - cell[k]) * T(spacing);
    }
  }

  template <class R>
  static Vec3<R> unit(const Vec3<R>& n) {
    const R length2 = dot(n, n);
    const auto has = length2 > scalar_t<R>(1e-12);  // none in the middle of a sheet
    const R inv = rsqrt(select(has, length2, splat<R>(1)));
    return select(has, n * inv, Vec3<R>{R{}, R{}, splat<R>(1)});
  }

  // phi and a blend of normals at points in the grid, in cells from its first corner.
  template <class R, class M>
  Surface<R> blended(const Vec3<R>& cell, const M& wanted) const {
    alignas(64) scalar_t<R> quads[4 * width<R>] = {};
    for_lanes(wanted, [&](int l) {
      blend(detail::lane(cell.x, l), detail::lane(cell.y, l), detail::lane(cell.z, l), quads + 4 * l);
    });
    Surface<R> s;
    detail::packs_of_quads(quads, s.phi, s.normal.x, s.normal.y, s.normal.z);
    return s;
  }

  struct Cell {
    std::size_t brick, corner;  // places in `table` and, in quads, in `coarse`
    int i[3], b[3];
  };
  template <class T>
  Cell cell_of(T x, T y, T z) const {
    Cell c;
    const T u[3] = {x, y, z};
    for (std::size_t k = 0; k < 3; ++k) {
      c.i[k] = min(int(u[k]), cells * bricks[k] - 1);
      c.b[k] = c.i[k] / cells;
    }
    const auto row = [&](int more) {
      const auto ny = std::size_t(bricks[1] + more), nz = std::size_t(bricks[2] + more);
      return (std::size_t(c.b[0]) * ny + std::size_t(c.b[1])) * nz + std::size_t(c.b[2]);
    };
    c.brick = row(0), c.corner = row(1);
    return c;
  }
  static std::size_t sample_of(const Cell& c) {
    return std::size_t(4 * (((c.i[0] % cells) * side + c.i[1] % cells) * side + c.i[2] % cells));
  }

  // The corner that is nearest to a point of its cell, or of its brick where that has no samples.
  template <class T>
  struct Nearest {
    float phi;
    int cells;       // how many a corner is from the next
    T along, away2;  // the ways to it along the axes, in these: their sum, and the sum of their squares
  };
  template <class T>
  Nearest<T> nearest(T x, T y, T z) const {
    const Cell c = cell_of(x, y, z);
    const std::int32_t brick = table[c.brick];
    const bool rough = brick == coarse_only;
    const T u[3] = {x, y, z};
    std::size_t up[3];
    Nearest<T> out{0, rough ? cells : 1, 0, 0};
    for (int k = 0; k < 3; ++k) {
      const T f = rough ? (u[k] - T(cells * c.b[k])) / T(cells) : u[k] - T(c.i[k]);
      up[k] = f > T(0.5) ? 1 : 0;
      const T way = up[k] ? T(1) - f : f;
      out.along += way, out.away2 += way * way;
    }
    if (rough) {
      const auto ny = std::size_t(bricks[1] + 1), nz = std::size_t(bricks[2] + 1);
      out.phi = coarse[4 * (c.corner + (up[0] * ny + up[1]) * nz + up[2])];
    } else {
      out.phi = fine[std::size_t(brick) * brick_floats + sample_of(c) +
                     4 * ((up[0] * side + up[1]) * side + up[2])];
    }
    return out;
  }

  // The quad at one point, in cells from the grid's first corner.
  template <class T>
  void blend(T x, T y, T z, T* quad) const {
    const Cell c = cell_of(x, y, z);
    const std::int32_t brick = table[c.brick];
    if (brick != coarse_only) {
      const float* p = fine + std::size_t(brick) * brick_floats + sample_of(c);
      blend(p, 4 * side * side, 4 * side, x - T(c.i[0]), y - T(c.i[1]), z - T(c.i[2]), quad);
    } else {
      const auto dy = std::size_t(4 * (bricks[2] + 1));
      const std::size_t dx = dy * std::size_t(bricks[1] + 1);
      const T part = T(1) / T(cells);
      blend(coarse + 4 * c.corner, dx, dy, x * part - T(c.b[0]), y * part - T(c.b[1]), z * part - T(c.b[2]),
            quad);
    }
  }
  template <class T>
  static void blend(const float* p, std::size_t dx, std::size_t dy, T x, T y, T z, T* quad) {
    using Q = detail::Quads<T>;
    const Q a = detail::load_two_quads<T>(p), b = detail::load_two_quads<T>(p + dy),
            c = detail::load_two_quads<T>(p + dx), d = detail::load_two_quads<T>(p + dx + dy);
    const Q ab = a + (b - a) * y, cd = c + (d - c) * y;
    detail::store_blend<T>(ab + (cd - ab) * x, z, quad);
  }
};

}  // namespace neve
