// What snow can lie on: all surfaces below open space, seen along upright lines over the cells of a square raster.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "geometry/triangle.hpp"

namespace neve::snowfall {

// What the triangles of a part bound.
enum class Part : std::uint8_t {
  closed,  // a body with an inside, triangles anticlockwise from outside
  sheet,   // a skin without thickness, with two sides
  ground   // all that is below is filled
};

struct Raster {
  double x0, y0;  // its least corner [m]
  double cell;    // edge of a cell [m]
  std::int32_t nx, ny;

  std::size_t columns() const { return std::size_t(nx) * std::size_t(ny); }
  std::size_t column(std::int32_t i, std::int32_t j) const {
    return std::size_t(i) * std::size_t(ny) + std::size_t(j);
  }
  bool holds(std::int32_t i, std::int32_t j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
  double x(std::int32_t i) const { return x0 + (i + 0.5) * cell; }
  double y(std::int32_t j) const { return y0 + (j + 0.5) * cell; }
};

// A launch site: a piece of a surface over the middle of a cell, and how far the space above it reaches.
struct Site {
  double z;              // height of the surface [m]
  double ceiling;        // height at which something hangs above it [m]; infinite under the sky
  double slope[2];       // of the surface, dz/dx and dz/dy [1]
  std::uint32_t column;  // over which cell of the raster
  std::int32_t part;     // whose surface
};

// The sites of all columns, those of a column from the top down.
class Columns {
 public:
  static constexpr double inf = std::numeric_limits<double>::infinity();
  static constexpr std::uint32_t none = 0xffffffffu;
  static constexpr double steepest = 3.732050807568877;  // tangent of 75 degrees: steeper counts as this
  static constexpr double least_room = 1e-3;             // space above a surface that is none [cells]

  // faces: corners of the triangles; part: of each face, which of `kinds` it belongs to.
  // Errors: std::invalid_argument for a raster without cells, corners or parts that are not there.
  Columns(const Raster& raster, const std::vector<Point>& vertices,
          const std::vector<std::array<std::int32_t, 3>>& faces, const std::vector<std::int32_t>& part,
          const std::vector<Part>& kinds)
      : raster_(raster) {
    if (!(raster.nx > 0 && raster.ny > 0 && raster.cell > 0))
      throw std::invalid_argument("a raster has one cell at least");
    std::vector<std::vector<Crossing>> crossings(raster.columns());
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (std::int32_t v : faces[f]) {
        if (v < 0 || std::size_t(v) >= vertices.size())
          throw std::invalid_argument("a face names a vertex that is not there");
      }
      if (part[f] < 0 || std::size_t(part[f]) >= kinds.size())
        throw std::invalid_argument("a face names a part that is not there");
      const auto corner = [&](int k) { return vertices[std::size_t(faces[f][std::size_t(k)])]; };
      cross({corner(0), corner(1), corner(2)}, part[f], crossings);
    }
    first_.push_back(0);
    for (std::size_t c = 0; c < crossings.size(); ++c) {
      walk_down(std::uint32_t(c), crossings[c], kinds);
      first_.push_back(std::uint32_t(sites_.size()));
    }
  }

  const Raster& raster() const { return raster_; }
  const std::vector<Site>& sites() const { return sites_; }
  std::uint32_t begin(std::size_t column) const { return first_[column]; }
  std::uint32_t end(std::size_t column) const { return first_[column + 1]; }
  // The site on which something at height z over a column stands or falls; none inside a body, or over a void.
  std::uint32_t below(std::size_t column, double z) const {
    for (std::uint32_t s = begin(column); s < end(column); ++s) {
      if (z >= sites_[s].z) return z < sites_[s].ceiling ? s : none;
    }
    return none;
  }
  // Whether the surface of s goes on over a neighbouring column, `run` away, above the height z: a slope upward.
  bool rises(std::uint32_t s, std::size_t column, double z, double run) const {
    for (std::uint32_t o = begin(column); o < end(column) && sites_[o].z > z; ++o) {
      if (sites_[o].part == sites_[s].part && sites_[o].z - sites_[s].z <= steepest * run) return true;
    }
    return false;
  }
  // Whether something at height z over a column, which no site is below of, falls without end.
  bool bottomless(std::size_t column, double z) const { return z < void_[column]; }
  // The site over the column beside that of s, di and dj cells away, that is one surface with it: its top is no
  // steeper than 75 degrees away, and the other way round it finds s. top: of the snow on each site [m].
  std::uint32_t joined(std::uint32_t s, int di, int dj, const double* top) const {
    const std::uint32_t o = near(s, di, dj, top);
    return o != none && near(o, -di, -dj, top) == s ? o : none;
  }
  std::array<std::int32_t, 2> place(std::uint32_t s) const {
    const auto c = std::int32_t(sites_[s].column);
    return {c / raster_.ny, c % raster_.ny};
  }

 private:
  std::uint32_t near(std::uint32_t s, int di, int dj, const double* top) const {
    const auto [i, j] = place(s);
    if (!raster_.holds(i + di, j + dj)) return none;
    const std::size_t c = raster_.column(i + di, j + dj);
    for (std::uint32_t o = begin(c); o < end(c); ++o) {
      if (std::fabs(top[o] - top[s]) <= steepest * raster_.cell) return o;
    }
    return none;
  }

  struct Crossing {
    double z;
    double slope[2];
    std::int32_t part;
    bool up;  // the face looks upward
  };

  // Add where a triangle crosses the upright lines over the middles of cells. A line through an edge of two
  // triangles crosses one of them: both judge the edge by the same numbers.
  void cross(const Triangle& t, std::int32_t part, std::vector<std::vector<Crossing>>& out) const {
    const Point n = neve::cross(t.b - t.a, t.c - t.a);
    if (n.z == 0) return;
    const Point corner[3] = {t.a, t.b, t.c};
    double low[2] = {inf, inf}, high[2] = {-inf, -inf};
    for (const Point& p : corner) {
      low[0] = std::min(low[0], p.x), high[0] = std::max(high[0], p.x);
      low[1] = std::min(low[1], p.y), high[1] = std::max(high[1], p.y);
    }
    const auto cells = [&](double l, double h, double origin, std::int32_t count) {
      const double first = std::ceil((l - origin) / raster_.cell - 0.5 - 1e-9),
                   last = std::floor((h - origin) / raster_.cell - 0.5 + 1e-9);
      return std::array<std::int32_t, 2>{std::int32_t(std::clamp(first, 0.0, double(count))),
                                         std::int32_t(std::clamp(last, -1.0, double(count - 1)))};
    };
    const auto [i0, i1] = cells(low[0], high[0], raster_.x0, raster_.nx);
    const auto [j0, j1] = cells(low[1], high[1], raster_.y0, raster_.ny);
    double slope[2] = {-n.x / n.z, -n.y / n.z};
    const double steep = std::sqrt(slope[0] * slope[0] + slope[1] * slope[1]);
    const double share = steep > steepest ? steepest / steep : 1.0;
    for (std::int32_t i = i0; i <= i1; ++i) {
      for (std::int32_t j = j0; j <= j1; ++j) {
        const double x = raster_.x(i), y = raster_.y(j);
        bool inside = true;
        for (int k = 0; k < 3 && inside; ++k)
          inside = left_of(corner[k], corner[(k + 1) % 3], x, y) == (n.z > 0);
        if (!inside) continue;
        const double z = t.a.z + slope[0] * (x - t.a.x) + slope[1] * (y - t.a.y);
        const double lowest = std::min({t.a.z, t.b.z, t.c.z}), highest = std::max({t.a.z, t.b.z, t.c.z});
        out[raster_.column(i, j)].push_back(
            {std::clamp(z, lowest, highest), {slope[0] * share, slope[1] * share}, part, n.z > 0});
      }
    }
  }
  // Whether (x, y) lies to the left of the line from p to q; on the line one of the two directions says so.
  static bool left_of(const Point& p, const Point& q, double x, double y) {
    const bool swapped = q.x < p.x || (q.x == p.x && q.y < p.y);
    const Point &a = swapped ? q : p, &b = swapped ? p : q;
    const double side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    return (side >= 0) != swapped;
  }

  // Go down a line from the sky: a site is where open space ends.
  void walk_down(std::uint32_t column, std::vector<Crossing>& met, const std::vector<Part>& kinds) {
    std::stable_sort(met.begin(), met.end(), [](const Crossing& a, const Crossing& b) {
      return a.z != b.z ? a.z > b.z
                        : a.up > b.up;  // of two that touch, the lower begins before the upper ends
    });
    int inside = 0;
    double ceiling = inf;
    for (const Crossing& c : met) {
      const Part kind = kinds[std::size_t(c.part)];
      const bool open = inside == 0 && ceiling - c.z > least_room * raster_.cell;
      if (open && (c.up || kind == Part::sheet))
        sites_.push_back({c.z, ceiling, {c.slope[0], c.slope[1]}, column, c.part});
      if (kind == Part::ground) {
        if (!c.up) continue;
        void_.push_back(-inf);
        return;
      }
      if (kind == Part::closed) inside = std::max(0, inside + (c.up ? 1 : -1));
      if (inside == 0) ceiling = c.z;
    }
    void_.push_back(inside == 0 ? ceiling : -inf);
  }

  Raster raster_;
  std::vector<Site> sites_;
  std::vector<std::uint32_t> first_;
  std::vector<double> void_;  // below which height a column is open down to nothing
};

}  // namespace neve::snowfall
