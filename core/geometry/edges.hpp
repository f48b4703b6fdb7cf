// Whether triangles close: every edge is passed as often one way as the other.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

#include "geometry/triangle.hpp"

namespace neve {

// Then their boundary is nothing, and they wind around every point off the surface a whole number of times, however
// many meet at an edge. Corners at one place are one corner, so that a soup can close as well.
inline bool is_closed(const std::vector<Point>& vertices,
                      const std::vector<std::array<std::int32_t, 3>>& faces) {
  const auto before = [&](std::uint32_t i, std::uint32_t j) {
    const Point &p = vertices[i], &q = vertices[j];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  };
  std::vector<std::uint32_t> sorted(vertices.size()), corner(vertices.size());
  std::iota(sorted.begin(), sorted.end(), 0u);
  std::sort(sorted.begin(), sorted.end(), before);
  for (std::size_t n = 1; n < sorted.size(); ++n)
    corner[sorted[n]] = corner[sorted[n - 1]] + (before(sorted[n - 1], sorted[n]) ? 1u : 0u);
  struct Edge {
    std::uint64_t ends;
    int way;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * faces.size());
  for (const auto& face : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = corner[std::size_t(face[k])];
      const std::uint64_t b = corner[std::size_t(face[(k + 1) % 3])];
      if (a != b) edges.push_back(a < b ? Edge{a << 32 | b, 1} : Edge{b << 32 | a, -1});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
  int sum = 0;
  for (std::size_t n = 0; n < edges.size(); ++n) {
    sum += edges[n].way;
    const bool last = n + 1 == edges.size() || edges[n + 1].ends != edges[n].ends;
    if (last && sum != 0) return false;
  }
  return true;
}

}  // namespace neve
