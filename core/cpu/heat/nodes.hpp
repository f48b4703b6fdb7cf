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

  // Add w amount(p) to K quantities of the nodes of the stencil of each particle p, w its weights. No two particles reach a node
  // at once, and they come to it in one order for any number of threads.
  template <std::size_t K, class F>
  void scatter(const std::array<double*, K>& sums, F&& amount) const {
    grid_.turns.each(grid_.homes, [&](const Home& home, const Home&) {
      std::array<Tile, K> tiles{};
      each_of_home(home, [&](std::size_t p, const Stencil& at) {
        const std::array<double, K> amounts = amount(p);
        for (std::size_t k = 0; k < K; ++k) at.add(tiles[k], amounts[k]);
      });
      for (std::size_t k = 0; k < K; ++k) {
        each_row(home, [&](std::size_t node, double* row) { add_row(sums[k] + node, row); }, tiles[k]);
      }
    });
  }
  // Call take(p, means) for each particle: the sums of w times K quantities of the nodes.
  template <std::size_t K, class F>
  void gather(const std::array<const double*, K>& of, F&& take) const {
    each_with_tiles(of, [&](std::size_t p, const Stencil& at, const std::array<Tile, K>& tiles) {
      std::array<double, K> means;
      for (std::size_t k = 0; k < K; ++k) means[k] = at.mean(tiles[k]);
      take(p, means);
    });
  }
  // Call take(p, slopes) for each particle: their gradients [1/m].
  template <std::size_t K, class F>
  void gather_slopes(const std::array<const double*, K>& of, F&& take) const {
    each_with_tiles(of, [&](std::size_t p, const Stencil& at, const std::array<Tile, K>& tiles) {
      std::array<std::array<double, 3>, K> slopes;
      for (std::size_t k = 0; k < K; ++k) slopes[k] = at.slope(tiles[k], inv_dx_);
      take(p, slopes);
    });
  }

 private:
  static constexpr std::size_t edge =
      8;  // of a tile: the nodes of the two by two by two blocks that a home reaches
  using Tile = std::array<double, edge * edge * edge>;

  // The weights of a particle, and the first of its nodes in the tile.
  struct Stencil {
    double w[3][3], dw[3][3];
    std::size_t first;

    template <class F>
    static void each_row(F&& f) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) f(i, j, (i * edge + j) * edge);
      }
    }
    void add(Tile& tile, double amount) const {
      each_row([&](std::size_t i, std::size_t j, std::size_t at) {
        const double share = amount * w[0][i] * w[1][j];
        double* row = tile.data() + first + at;
        for (std::size_t k = 0; k < 3; ++k) row[k] += share * w[2][k];
      });
    }
    double mean(const Tile& tile) const {
      double sum = 0;
      each_row([&](std::size_t i, std::size_t j, std::size_t at) {
        const double* row = tile.data() + first + at;
        sum += w[0][i] * w[1][j] * (row[0] * w[2][0] + row[1] * w[2][1] + row[2] * w[2][2]);
      });
      return sum;
    }
    std::array<double, 3> slope(const Tile& tile, double inv_dx) const {
      std::array<double, 3> sum{};
      each_row([&](std::size_t i, std::size_t j, std::size_t at) {
        const double* row = tile.data() + first + at;
        const double value = row[0] * w[2][0] + row[1] * w[2][1] + row[2] * w[2][2];
        sum[0] += dw[0][i] * w[1][j] * value, sum[1] += w[0][i] * dw[1][j] * value;
        sum[2] += w[0][i] * w[1][j] * (row[0] * dw[2][0] + row[1] * dw[2][1] + row[2] * dw[2][2]);
      });
      for (double& u : sum) u *= inv_dx;
      return sum;
    }
  };

  // Call f(p, stencil) for the particles of a home.
  template <class F>
  void each_of_home(const Home& home, F&& f) const {
    const std::int32_t origin[3] = {home.at.x, home.at.y, home.at.z};
    Stencil at;
    for (std::uint32_t n = home.begin; n < home.begin + home.count; ++n) {
      const std::size_t p = grid_.order[n];
      at.first = 0;
      for (int a = 0; a < 3; ++a) {
        const double s = std::clamp(
            double(state_.x.column(a)[p]) * inv_dx_ - Quadratic::shift - 4.0 * origin[a], 0.0, 5.0);
        const int base = std::min(int(s), 5);
        Quadratic::weights(s - base, at.w[a], at.dw[a]);
        at.first = at.first * edge + std::size_t(base);
      }
      f(p, at);
    }
  }

  // Call f(node, row) for each four nodes of a tile that follow one another.
  template <class F>
  static void each_row(const Home& home, F&& f, Tile& tile) {
    for (std::size_t b = 0; b < 8; ++b) {
      if (home.nodes[b] < 0) continue;
      const std::size_t corner = (b >> 2) * 4 * edge * edge + (b >> 1 & 1) * 4 * edge + (b & 1) * 4;
      for (std::size_t r = 0; r < 16; ++r)
        f(std::size_t(home.nodes[b]) * 64 + r * 4,
          tile.data() + corner + (r >> 2) * edge * edge + (r & 3) * edge);
    }
  }
  static void add_row(double* nodes, const double* row) {
    for (int k = 0; k < 4; ++k) nodes[k] += row[k];
  }

  // Call f(p, stencil, tiles) for each particle, with K quantities of the nodes around it.
  template <std::size_t K, class F>
  void each_with_tiles(const std::array<const double*, K>& of, F&& f) const {
    each_index(grid_.homes.size(), [&](std::size_t h) {
      const Home& home = grid_.homes[h];
      std::array<Tile, K> tiles{};
      for (std::size_t k = 0; k < K; ++k) {
        each_row(home, [&](std::size_t node, double* row) { std::copy_n(of[k] + node, 4, row); }, tiles[k]);
      }
      each_of_home(home, [&](std::size_t p, const Stencil& at) { f(p, at, tiles); });
    });
  }

  const State<T>& state_;
  double inv_dx_;
  Grid<T> grid_;
  std::vector<std::array<std::int32_t, 27>> around_;
};

}  // namespace neve::detail
