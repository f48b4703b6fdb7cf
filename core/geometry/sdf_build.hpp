// Build the signed distance grid of a mesh. The same bits for any number of threads: each value depends on its place.
#pragma once

#include "geometry/sdf_grid.hpp"
#include "geometry/triangle_mesh.hpp"
#include "threads.hpp"

namespace neve {

// phi is the distance to the nearest triangle, negative where the winding number says inside (TriangleMesh::winds);
// with a thickness it is the distance less half of that, whatever is inside. Normals are central differences of phi
// over a spacing each way, which rounds edges off by that much on the outside. Inside, where differences between
// two sides are cut short and leave what is along the sides, they point to the nearer side.
class SdfBuilder {
 public:
  // Errors: std::invalid_argument for sizes that are not above zero or a grid of more than 2^27 bricks.
  SdfBuilder(const TriangleMesh& mesh, double spacing, double band, double thickness)
      : mesh_(mesh), half_thickness_(0.5 * thickness) {
    if (!(spacing > 0 && spacing < 1e30)) throw std::invalid_argument("spacing: a length above zero");
    if (!(band >= 0 && band < 1e30)) throw std::invalid_argument("band: a length, not below zero");
    if (!(thickness >= 0 && thickness < 1e30))
      throw std::invalid_argument("thickness: a length, not below zero");
    grid_.spacing = spacing, grid_.band = band, grid_.thickness = thickness;
    const double room = std::max(band, 2 * spacing), brick = SdfGrid::cells * spacing;
    double count = 1;
    for (int k = 0; k < 3; ++k) {
      grid_.low[k] = mesh.bounds().low[k] - half_thickness_;
      grid_.high[k] = mesh.bounds().high[k] + half_thickness_;
      const double n = std::ceil((grid_.high[k] - grid_.low[k] + 2 * room) / brick);
      count *= n + 1;
      if (!(count < 0x1p27))
        throw std::invalid_argument("spacing: too fine, the grid would have more than 2^27 bricks");
      grid_.bricks[k] = std::int32_t(n);
      grid_.box_low[k] = mesh.bounds().middle()[k] - 0.5 * n * brick;
    }
  }

  // What the grid will take [bytes], at a small part of the cost of building it.
  std::size_t bytes() {
    find_bricks();
    const auto& b = grid_.bricks;
    const auto corners = std::size_t(b[0] + 1) * std::size_t(b[1] + 1) * std::size_t(b[2] + 1);
    return sizeof(SdfGrid) + grid_.table.size() * sizeof(std::int32_t) +
           (4 * corners + places_.size() * SdfGrid::brick_floats) * sizeof(float);
  }

  SdfGrid build() {
    find_bricks();
    fill_coarse();
    grid_.fine.resize(places_.size() * SdfGrid::brick_floats);
    std::vector<Share> shares(places_.size());
    each_index(places_.size(), [&](std::size_t n) { shares[n] = fill_distances(n); });
    each_index(places_.size(), [&](std::size_t n) { fill_normals(n); });
    Share all;
    for (const Share& s : shares) all.near += s.near, all.open += s.open;
    grid_.openness = all.near > 0 ? double(all.open) / double(all.near) : 0.0;
    return std::move(grid_);
  }

 private:
  static constexpr int cells = SdfGrid::cells, side = SdfGrid::side;
  using Index = std::array<std::int32_t, 3>;  // of a sample, a cell or a brick
  struct Share {
    std::int64_t near = 0, open = 0;
  };
  struct Value {
    double phi, winding;
    TriangleMesh::Nearest nearest;
  };

  Point place(std::int32_t i, std::int32_t j, std::int32_t k) const {
    const double h = grid_.spacing;
    return grid_.box_low + Point{h * i, h * j, h * k};
  }
  std::size_t row(const Index& b) const {
    const auto& n = grid_.bricks;
    return (std::size_t(b[0]) * std::size_t(n[1]) + std::size_t(b[1])) * std::size_t(n[2]) +
           std::size_t(b[2]);
  }
  float* quad(std::size_t brick, int i, int j, int k) {
    return grid_.fine.data() + brick * SdfGrid::brick_floats + 4 * ((i * side + j) * side + k);
  }
  const float* quad(std::size_t brick, int i, int j, int k) const {
    return grid_.fine.data() + brick * SdfGrid::brick_floats + 4 * ((i * side + j) * side + k);
  }

  Value value(const Point& x) const {
    Value v{0, 0, mesh_.nearest(x)};
    v.phi = v.nearest.distance() - half_thickness_;
    if (half_thickness_ > 0) return v;
    v.winding = mesh_.winding(x);
    if (TriangleMesh::winds(v.winding)) v.phi = -v.phi;
    return v;
  }
  // The value one spacing from another, which says much of it: the distance is at most a spacing more, and if the
  // surface is farther from there than a spacing and closed, both are on one side of it.
  Value value_beside(const Value& other, const Point& x) const {
    const double d = other.nearest.distance(), step = grid_.spacing * (1 + 1e-6);
    Value v{0, other.winding, mesh_.nearest(x, (d + step) * (1 + 1e-6))};
    v.phi = v.nearest.distance() - half_thickness_;
    if (half_thickness_ > 0) return v;
    if (!(mesh_.closed() && d > step)) v.winding = mesh_.winding(x);
    if (TriangleMesh::winds(v.winding)) v.phi = -v.phi;
    return v;
  }
  // The direction of growing phi at a point, from the nearest point of the surface or, on it, from its triangle.
  Point straight_normal(const Point& x, const Value& v) const {
    Point n = x - v.nearest.point;
    double length = std::sqrt(dot(n, n));
    const bool on = !(length > 1e-9 * grid_.spacing);
    if (on) {
      n = mesh_.triangles()[v.nearest.triangle].area_vector();
      length = std::sqrt(dot(n, n));
    }
    return n * ((!on && half_thickness_ == 0 && v.phi < 0 ? -1.0 : 1.0) / length);
  }

  // Halve boxes of cells down to 2^3 wherever the band may be in them, and mark the bricks in which some remain.
  void find_bricks() {
    if (!grid_.table.empty()) return;
    const auto& b = grid_.bricks;
    grid_.table.assign(row({b[0] - 1, b[1] - 1, b[2] - 1}) + 1, SdfGrid::coarse_only);
    search({0, 0, 0}, {cells * b[0], cells * b[1], cells * b[2]});
    Index at;
    for (at[0] = 0; at[0] < b[0]; ++at[0]) {
      for (at[1] = 0; at[1] < b[1]; ++at[1]) {
        for (at[2] = 0; at[2] < b[2]; ++at[2]) {
          std::int32_t& mark = grid_.table[row(at)];
          if (mark == SdfGrid::coarse_only) continue;
          mark = std::int32_t(places_.size());
          places_.push_back(at);
        }
      }
    }
  }
  void search(const Index& from, const Index& to) {
    std::size_t longest = 0;
    double half2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double half = 0.5 * grid_.spacing * (to[k] - from[k]);
      half2 += half * half;
      if (to[k] - from[k] > to[longest] - from[longest]) longest = k;
    }
    const std::int32_t extent = to[longest] - from[longest];
    std::int32_t& mark = grid_.table[row({from[0] / cells, from[1] / cells, from[2] / cells})];
    if (extent <= cells && mark != SdfGrid::coarse_only) return;
    const Point middle = (place(from[0], from[1], from[2]) + place(to[0], to[1], to[2])) * 0.5;
    const double phi = mesh_.nearest(middle).distance() - half_thickness_;
    if (std::fabs(phi) > grid_.band + std::sqrt(half2)) return;
    if (extent <= 2) {
      mark = 0;
      return;
    }
    // bricks stay whole as long as they can
    const std::int32_t grain = extent > cells ? cells : 2;
    const std::int32_t half = (extent / grain + 1) / 2 * grain;
    Index low_end = to, high_begin = from;
    low_end[longest] = high_begin[longest] = from[longest] + half;
    search(from, low_end);
    search(high_begin, to);
  }

  void fill_coarse() {
    const auto& b = grid_.bricks;
    const auto ny = std::size_t(b[1] + 1), nz = std::size_t(b[2] + 1);
    const std::size_t rows = std::size_t(b[0] + 1) * ny;
    grid_.coarse.resize(4 * rows * nz);
    each_index(rows, [&](std::size_t r) {
      for (std::size_t k = 0; k < nz; ++k) {
        const Point x =
            place(cells * std::int32_t(r / ny), cells * std::int32_t(r % ny), cells * std::int32_t(k));
        const Value v = value(x);
        put(grid_.coarse.data() + 4 * (r * nz + k), v.phi, straight_normal(x, v));
      }
    });
  }
  static void put(float* quad, double phi, const Point& n) {
    quad[0] = float(phi);
    for (int a = 0; a < 3; ++a) quad[a + 1] = float(n[a]);
  }

  // phi at all samples of one brick; and how many lie off the surface, and how many of those are neither in nor out.
  Share fill_distances(std::size_t n) {
    const Index& at = places_[n];
    const double near = std::max(grid_.band, 3 * grid_.spacing);
    Share share;
    Value v{};
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        for (int turn = 0; turn < side; ++turn) {
          const int k = j % 2 == 0 ? turn : side - 1 - turn;  // to and fro
          const Point x = place(cells * at[0] + i, cells * at[1] + j, cells * at[2] + k);
          v = j == 0 && turn == 0 ? value(x) : value_beside(v, x);
          quad(n, i, j, k)[0] = float(v.phi);
          const double d = v.nearest.distance();
          if (!(d > grid_.spacing && d < near)) continue;
          ++share.near;
          if (std::fabs(v.winding - std::round(v.winding)) > 0.25) ++share.open;
        }
      }
    }
    return share;
  }

  // phi at a sample of the whole lattice, from a brick that has it or from the mesh.
  double phi_at(std::int32_t i, std::int32_t j, std::int32_t k) const {
    for (int neighbour = 0; neighbour < 8; ++neighbour) {
      const Index sample{i, j, k};
      Index brick, in;
      bool has = true;
      for (std::size_t a = 0; a < 3 && has; ++a) {
        const int back = neighbour >> a & 1;
        brick[a] = (sample[a] >> 3) - back;
        in[a] = sample[a] - cells * brick[a];
        has = brick[a] >= 0 && brick[a] < grid_.bricks[a] && in[a] < side;
      }
      if (!has) continue;
      const std::int32_t n = grid_.table[row(brick)];
      if (n != SdfGrid::coarse_only) return quad(std::size_t(n), in[0], in[1], in[2])[0];
    }
    return value(place(i, j, k)).phi;
  }

  void fill_normals(std::size_t n) {
    const Index origin{cells * places_[n][0], cells * places_[n][1], cells * places_[n][2]};
    const auto phi = [&](int i, int j, int k) -> double {
      const bool in = i >= 0 && i < side && j >= 0 && j < side && k >= 0 && k < side;
      return in ? quad(n, i, j, k)[0] : phi_at(origin[0] + i, origin[1] + j, origin[2] + k);
    };
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        for (int k = 0; k < side; ++k) {
          Point g{phi(i + 1, j, k) - phi(i - 1, j, k), phi(i, j + 1, k) - phi(i, j - 1, k),
                  phi(i, j, k + 1) - phi(i, j, k - 1)};
          const double length = std::sqrt(dot(g, g)), h = grid_.spacing;
          const double least = phi(i, j, k) < 0 ? 0.9 : SdfGrid::least_slope;
          if (length > 2 * h * least) {
            g = g * (1.0 / length);
          } else {
            const Point x = place(origin[0] + i, origin[1] + j, origin[2] + k);
            g = straight_normal(x, value(x));
          }
          for (int a = 0; a < 3; ++a) quad(n, i, j, k)[a + 1] = float(g[a]);
        }
      }
    }
  }

  const TriangleMesh& mesh_;
  double half_thickness_;
  SdfGrid grid_;
  std::vector<Index> places_;  // of the bricks
};

}  // namespace neve
