// Boundaries beside water.
#pragma once

#include "sph/pairs.hpp"

namespace neve {

// What boundaries beside a plane fill of a kernel of water, over c^2, c = sum_b V_b W_ib: so that a layer of boundary particles
// takes the place of the layer of water that is missing there. That is sum_j V_j W_ij / c^2, of square lattices [1].
inline constexpr double wall_gain = 5.1237;

// Set `filled` of water beside boundaries, and make of the gradients of W those of what is filled:
//
//   filled_i = wall_gain sum_b sum_b' V_b W_ib V_b' W_ib' max(n_b . n_b', 0),    n: the normals,
//   wall_gain 2 sum_b' V_b' W_ib' max(n_b . n_b', 0) grad W_ib  in place of grad W_ib.
//
// Beside a plane that is a square. Its gradient pushes as strongly as two layers of water press on each other. With c in
// place of c^2 it would be half of that: water would lie half as far from walls as from itself. Walls at right angles add up.
template <class T>
void wet_walls(const CubicKernel<T>& kernel, const SphState<T>& s, const SphBoundary<T>& walls,
               SphPairs<T>& boundary) {
  if (!s.has_water()) return;
  boundary.filled.assign(s.count, T(0));
  each_row(s.count, [&](std::size_t p) {
    if (!s.is_water(p)) return;
    const std::uint32_t first = boundary.begin[p], count = boundary.begin[p + 1] - first;
    std::vector<T> covered(count);
    std::vector<Vec3<T>> normal(count);
    for (std::uint32_t e = 0; e < count; ++e) {
      const auto b = std::size_t(boundary.row[first + e]);
      const Vec3<T> x = vector_at(s.x, p) - vector_at(walls.x, b);
      covered[e] = walls.V.column(0)[b] * kernel.value(dot(x, x)), normal[e] = vector_at(walls.normal, b);
    }
    for (std::uint32_t e = 0; e < count; ++e) {
      T together = 0;
      for (std::uint32_t k = 0; k < count; ++k)
        together += covered[k] * std::max(dot(normal[e], normal[k]), T(0));
      boundary.filled[p] += T(wall_gain) * covered[e] * together;
      for (auto& g : boundary.gradient) g[first + e] *= T(2 * wall_gain) * together;
    }
  });
}

}  // namespace neve
