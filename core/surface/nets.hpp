// The surface on which a field has some value, as triangles: surface nets (Gibson 1998).
#pragma once

#include <array>

#include "surface/field.hpp"

namespace neve::surface {

struct Triangles {
  std::vector<float> vertices, normals;  // three numbers each; normals of unit length, towards lower values
  std::vector<std::int32_t> faces;       // three vertices each, seen from outside counter-clockwise
};

// Cubes have the centres of eight neighbouring cells as corners. A cube with corners on both sides of the surface gets
// one vertex, the mean of the points where the surface crosses its edges; an edge that the surface crosses gets the
// four vertices of the cubes around it, as two triangles. So the surface is closed: no edge of a triangle is free.
class Nets {
 public:
  Nets(const Field& field, float level) : field_(field), level_(level) {
    const int n = field.blocks.count();
    number_.assign(std::size_t(n) * cubes, -1);
    for (int b = 0; b < n; ++b) each(b, [&](int i, int j, int k) { place(b, i, j, k); });
    for (int b = 0; b < n; ++b)
      each(b, [&](int i, int j, int k) {
        for (int axis = 0; axis < 3; ++axis) join(b, {i, j, k}, axis);
      });
  }

  Triangles take() { return std::move(out_); }

 private:
  static constexpr int side = Blocks::side, cubes = side * side * side;
  using Place = std::array<int, 3>;

  template <class F>
  static void each(int, F&& f) {
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j)
        for (int k = 0; k < side; ++k) f(i, j, k);
  }
  static std::size_t slot(int block, int i, int j, int k) {
    return std::size_t(block) * cubes + std::size_t((i * side + j) * side + k);
  }

  void place(int block, int i, int j, int k) {
    const float* v = field_.blocks.values(block) + Blocks::at(i, j, k);
    float corner[8];
    int inside = 0;
    for (int c = 0; c < 8; ++c) {
      corner[c] = v[Blocks::at(c & 1, c >> 1 & 1, c >> 2)] - level_;
      inside += corner[c] > 0;
    }
    if (inside == 0 || inside == 8) return;
    Vec3f sum{}, slope{};
    float crossings = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (int c = 0; c < 8; ++c) {
        if (c >> axis & 1) continue;
        const float a = corner[c], b = corner[c | 1 << axis];
        slope[axis] += b - a;
        if ((a > 0) == (b > 0)) continue;
        Vec3f at{float(c & 1), float(c >> 1 & 1), float(c >> 2)};
        at[axis] = a / (a - b);
        sum += at;
        crossings += 1;
      }
    const Int3 w = field_.blocks.where(block);
    const Vec3f first{float(w.x * side + i) + 0.5f, float(w.y * side + j) + 0.5f,
                      float(w.z * side + k) + 0.5f};
    const Vec3f x = field_.origin + (first + sum * (1.0f / crossings)) * field_.blocks.cell_size();
    const Vec3f normal = normalize(-slope);
    number_[slot(block, i, j, k)] = std::int32_t(out_.vertices.size() / 3);
    out_.vertices.insert(out_.vertices.end(), {x.x, x.y, x.z});
    out_.normals.insert(out_.normals.end(), {normal.x, normal.y, normal.z});
  }

  // The vertex of the cube at `at`, which may lie one before the block.
  std::int32_t vertex(int block, Place at) const {
    if (at[0] < 0 || at[1] < 0 || at[2] < 0) {
      const Int3 w = field_.blocks.where(block);
      block = field_.blocks.find({w.x - (at[0] < 0), w.y - (at[1] < 0), w.z - (at[2] < 0)});
      if (block < 0) return -1;
    }
    return number_[slot(block, at[0] & Blocks::mask, at[1] & Blocks::mask, at[2] & Blocks::mask)];
  }

  void join(int block, Place at, int axis) {
    const float* v = field_.blocks.values(block) + Blocks::at(at[0], at[1], at[2]);
    const bool here = v[0] > level_, there = v[Blocks::at(axis == 0, axis == 1, axis == 2)] > level_;
    if (here == there) return;
    const int u = (axis + 1) % 3, w = (axis + 2) % 3;
    std::int32_t corner[4];
    for (int c = 0; c < 4; ++c) {
      Place cube = at;
      cube[std::size_t(u)] -= c == 1 || c == 2;
      cube[std::size_t(w)] -= c == 2 || c == 3;
      corner[c] = vertex(block, cube);
      if (corner[c] < 0) return;
    }
    if (there) std::swap(corner[1], corner[3]);
    const int turn =
        apart(corner[0], corner[2]) <= apart(corner[1], corner[3]) ? 0 : 1;  // the shorter diagonal
    const auto at_turn = [&](int c) { return corner[(c + turn) % 4]; };
    out_.faces.insert(out_.faces.end(),
                      {at_turn(0), at_turn(1), at_turn(2), at_turn(0), at_turn(2), at_turn(3)});
  }

  float apart(std::int32_t a, std::int32_t b) const {
    const float* p = out_.vertices.data() + 3 * std::size_t(a);
    const float* q = out_.vertices.data() + 3 * std::size_t(b);
    const Vec3f d{p[0] - q[0], p[1] - q[1], p[2] - q[2]};
    return dot(d, d);
  }

  const Field& field_;
  float level_;
  std::vector<std::int32_t> number_;  // of the vertex in each cube, -1 for none
  Triangles out_;
};

}  // namespace neve::surface
