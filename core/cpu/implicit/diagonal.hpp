// The diagonal of the stiffness: for axis a of node i, sum_p g_ip^T S_a g_ip, with S_a of each particle by its tangent.
#pragma once

#include "cpu/implicit/passes.hpp"
#include "cpu/implicit/tangents.hpp"

namespace neve {

// to_i += sum_p (g_ip^T S_x g_ip, g_ip^T S_y g_ip, g_ip^T S_z g_ip), of the particles of homes with wanted(home).
template <class T, class Spline, class Weights, class Wanted>
void add_stiffness_diagonal(const Model<T>& model, const State<T>& state, Grid<T>& grid,
                            const Tangents<T>& tangents, NodeField<T>& to, Wanted&& wanted) {
  using R = Lanes<T>;
  constexpr int K = Spline::nodes;
  grid.turns.each(grid.homes, [&](const Home& home, const Home&) {
    if (!wanted(home)) return;
    Tile<T> sums;
    sums.clear();
    const auto frame = TileFrame<T>::template of<Spline>(model.dx, home.at);
    Stencils<T, Spline, 2> stencils;
    detail::each_pack(state, frame, home, [&](std::size_t p, int count, const Vec3<R>& way) {
      stencils.template fill<Weights>(frame, way);
      alignas(64) T form[6][4 * width<R>];  // a quad for each particle: of the axes x, y, z
      const auto S = tangents.diagonal_forms(p, count);
      for (std::size_t k = 0; k < 6; ++k) store_quads(form[k], S[k].x, S[k].y, S[k].z, splat<R>(0));
      for (int lane = 0; lane < count; ++lane) {
        T* corner = sums.value + stencils.cell[lane];
        for (int i = 0; i < K; ++i) {
          for (int j = 0; j < K; ++j) {
            const T plain = stencils.x[0][i][lane] * stencils.y[0][j][lane],
                    along_x = stencils.x[1][i][lane] * stencils.y[0][j][lane],
                    along_y = stencils.x[0][i][lane] * stencils.y[1][j][lane];
            T* row = corner + row_offset(i, j);
            for (int k = 0; k < K; ++k) {
              const T w = stencils.z[0][4 * lane + k], x = along_x * w, y = along_y * w,
                      z = plain * stencils.z[1][4 * lane + k];
              const T square[6] = {x * x, y * y, z * z, T(2) * x * y, T(2) * x * z, T(2) * y * z};
              for (int a = 0; a < 4; ++a) {
                T sum = T(0);
                for (int q = 0; q < 6; ++q) sum += square[q] * form[q][4 * lane + a];
                row[4 * k + a] += sum;
              }
            }
          }
        }
      }
    });
    sums.add_to(home, [&](std::int32_t b) { return to.block(std::size_t(b)); });
  });
}

}  // namespace neve
