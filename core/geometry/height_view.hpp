// Ground given by heights over a rectangle, in its own frame: local z is up, the rectangle's middle is x = y = 0.
#pragma once

#include "geometry/quads.hpp"
#include "geometry/surface.hpp"
#include "math/standard.hpp"

namespace neve {

// A field whose samples another owns. Heights are bilinear between the samples; beyond an edge the edge's height goes on for ever. Below the surface all is
// ground, however deep.
//
// phi = (z - h) n_z, n along (-dh/dx, -dh/dy, 1): the distance to the tangent plane, exact for planes. Where the
// ground's steepest slope is s, the distance is between |z - h| / sqrt(1 + s^2) and |z - h|, and so is |phi|. Slopes
// are central differences at the samples, bilinear between: the normal turns smoothly over two spacings.
struct HeightView {
  static constexpr int tile_cells = 8;

  std::int32_t nx = 0, ny = 0, tiles_x = 0, tiles_y = 0;  // samples and tiles along each axis
  double size_x = 0, size_y = 0;                          // of the rectangle [m]
  const float* quads = nullptr;                           // h [m], dh/dx, dh/dy, 0
  const float* tops = nullptr;                            // the largest height of each tile of 8^2 cells [m]

  // Where the quad of a sample begins.
  std::size_t quad(std::int32_t i, std::int32_t j) const {
    return 4 * (std::size_t(i) * std::size_t(ny) + std::size_t(j));
  }
  float height(std::int32_t i, std::int32_t j) const { return quads[quad(i, j)]; }

  // phi and normal at points in the ground's frame.
  template <class R>
  Surface<R> at(const Vec3<R>& x) const {
    using T = scalar_t<R>;
    const R a = (x.x + T(0.5 * size_x)) * T((nx - 1) / size_x);
    const R b = (x.y + T(0.5 * size_y)) * T((ny - 1) / size_y);
    const R u = clamp(a, R{}, splat<R>(T(nx - 1))), v = clamp(b, R{}, splat<R>(T(ny - 1)));
    alignas(64) T quads[4 * width<R>];
    for (int l = 0; l < width<R>; ++l) blend(detail::lane(u, l), detail::lane(v, l), quads + 4 * l);
    R h, slope_x, slope_y, unused;
    detail::packs_of_quads(quads, h, slope_x, slope_y, unused);
    slope_x = select(a == u, slope_x, R{});
    slope_y = select(b == v, slope_y, R{});
    const R n_z = rsqrt(R(slope_x * slope_x + slope_y * slope_y + T(1)));
    return {(x.z - h) * n_z, {-slope_x * n_z, -slope_y * n_z, n_z}};
  }

  // Whether the ground may be within `reach` [m] of x; false only if it is not.
  bool is_near(const Vec3<double>& x, double reach) const {
    const auto tile = [&](double at, double size, std::int32_t n, std::int32_t tiles) {
      const double cell = (at / size + 0.5) * (n - 1);
      return std::int32_t(clamp(std::floor(cell / tile_cells), 0.0, double(tiles - 1)));
    };
    const std::int32_t i1 = tile(x.x + reach, size_x, nx, tiles_x),
                       j0 = tile(x.y - reach, size_y, ny, tiles_y),
                       j1 = tile(x.y + reach, size_y, ny, tiles_y);
    for (std::int32_t i = tile(x.x - reach, size_x, nx, tiles_x); i <= i1; ++i) {
      for (std::int32_t j = j0; j <= j1; ++j) {
        if (x.z - reach <= double(tops[std::size_t(i * tiles_y + j)])) return true;
      }
    }
    return false;
  }

 private:
  // The quad at one point, in cells from the first corner.
  template <class T>
  void blend(T u, T v, T* out) const {
    const std::int32_t i = min(std::int32_t(u), nx - 2), j = min(std::int32_t(v), ny - 2);
    const float* p = quads + quad(i, j);
    const auto a = detail::load_two_quads<T>(p), b = detail::load_two_quads<T>(p + quad(1, 0));
    detail::store_blend<T>(a + (b - a) * (u - T(i)), v - T(j), out);
  }
};

}  // namespace neve
