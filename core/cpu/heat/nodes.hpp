// A grid of its own for what heat asks of the particles, sleepers included: sums over quadratic B-splines, in double.
#pragma once

#include "cpu/grid/sort.hpp"
#include "heat/enthalpy.hpp"

namespace neve::detail {

// Blocks of nodes around all particles, and which particles lie where. The state stays as it is.
template <class T>
class HeatNodes {
 public:
  HeatNodes(const Model<T>& model, const State<T>& state) : state_(state), inv_dx_(1 / model.dx) {
    const Placing<T> placing{T(inv_dx_), T(Quadratic::shift), T(Quadratic::margin), int(Quadratic::margin)};
    const std::vector<BlockKey> keys = find_homes(state, state.count, placing, grid_);
    order_by_home<T>(state.count, keys, grid_);
    grid_.moving = grid_.homes.size();
    lay_out_blocks(grid_);
    BlockMap map(grid_.blocks.size() * 2 + 8);
    for (const BlockCoord& at : grid_.blocks) map.insert(key_of(at));
    around_.resize(grid_.blocks.size());
    for (std::size_t b = 0; b < grid_.blocks.size(); ++b) {
      const BlockCoord at = grid_.blocks[b];
      for (int n = 0; n < 27; ++n)
        around_[b][std::size_t(n)] =
            map.find(key_of({at.x + n / 9 - 1, at.y + n / 3 % 3 - 1, at.z + n % 3 - 1}));
    }
  }

  // How many numbers a quantity of all nodes has.
  std::size_t size() const { return grid_.blocks.size() * 64; }
  const std::vector<BlockCoord>& blocks() const { return grid_.blocks; }
  static constexpr std::size_t none = ~std::size_t(0);

  // Place of the node (i, j, k) from the first of a block, -1 to 4 each; none where no block is.
  std::size_t at(std::size_t block, int i, int j, int k) const {
    const int n = ((i + 4) >> 2) * 9 + ((j + 4) >> 2) * 3 + ((k + 4) >> 2);
    const std::int32_t b = around_[block][std::size_t(n)];
    if (b == BlockMap::none) return none;
    return std::size_t(b) * 64 + std::size_t((i & 3) * 16 + (j & 3) * 4 + (k & 3));
  }

  // Call scatter(p, node, w, dw) for each particle p and each node of its stencil, dw the gradient of its weight [1/m]. No two
  // particles reach a node at once, and they come to it in one order for any number of threads.
  template <class F>
  void scatter(F&& f) {
    for (const auto& colour : grid_.colours) {
      each_index(colour.size(), [&](std::size_t c) { each_of_home(grid_.homes[std::size_t(colour[c])], f); });
    }
  }
  // The same in any order, for what only changes p.
  template <class F>
  void gather(F&& f) {
    each_index(grid_.homes.size(), [&](std::size_t h) { each_of_home(grid_.homes[h], f); });
  }

 private:
  template <class F>
  void each_of_home(const Home& home, F&& f) {
    const std::int32_t origin[3] = {home.at.x, home.at.y, home.at.z};
    for (std::uint32_t n = home.begin; n < home.begin + home.count; ++n) {
      const std::size_t p = grid_.order[n];
      double w[3][3], dw[3][3];
      int base[3];
      for (int a = 0; a < 3; ++a) {
        const double s = std::clamp(
            double(state_.x.column(a)[p]) * inv_dx_ - Quadratic::shift - 4.0 * origin[a], 0.0, 5.0);
        base[a] = std::min(int(s), 5);
        Quadratic::weights(s - base[a], w[a], dw[a]);
      }
      for (int ijk = 0; ijk < 27; ++ijk) {
        const int i = ijk / 9, j = ijk / 3 % 3, k = ijk % 3;
        const int x = base[0] + i, y = base[1] + j, z = base[2] + k;
        const std::int32_t b = home.nodes[std::size_t((x >> 2) * 4 + (y >> 2) * 2 + (z >> 2))];
        const auto node = std::size_t(b) * 64 + std::size_t((x & 3) * 16 + (y & 3) * 4 + (z & 3));
        f(p, node, w[0][i] * w[1][j] * w[2][k],
          std::array<double, 3>{dw[0][i] * w[1][j] * w[2][k] * inv_dx_,
                                w[0][i] * dw[1][j] * w[2][k] * inv_dx_,
                                w[0][i] * w[1][j] * dw[2][k] * inv_dx_});
      }
    }
  }

  const State<T>& state_;
  double inv_dx_;
  Grid<T> grid_;
  std::vector<std::array<std::int32_t, 27>> around_;
};

}  // namespace neve::detail
