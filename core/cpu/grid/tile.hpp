// A home's 8x8x8 nodes, in one piece.
#pragma once

#include "cpu/grid/grid.hpp"
#include "math/rows.hpp"

namespace neve {

inline constexpr int tile_width = 8;
inline constexpr int tile_values = tile_width * tile_width * tile_width * 4;

// A home's 8x8x8 nodes; one row of slack, since a row operation reads and writes four nodes for a stencil of three.
template <class T>
struct Tile {
  alignas(64) T value[tile_values + 16];

  void clear() { std::memset(value, 0, sizeof(value)); }
  // Call f(pointer into the tile, pointer into the node block) for each row of four nodes.
  template <class F>
  void each_row(const Home& home, F&& f, T* (Grid<T>::*block)(std::int32_t), Grid<T>& grid) {
    for (int k = 0; k < 8; ++k) {
      const std::int32_t b = home.nodes[static_cast<std::size_t>(k)];
      if (b == BlockMap::none) continue;  // of a sleeper: nobody looks at it
      T* nodes = (grid.*block)(b);
      T* corner = value + (((k >> 2) * 4 * tile_width + ((k >> 1) & 1) * 4) * tile_width + (k & 1) * 4) * 4;
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j)
          f(corner + (i * tile_width + j) * tile_width * 4, nodes + (i * 4 + j) * 16);
      }
    }
  }
  void load_from(Grid<T>& grid, const Home& home, T* (Grid<T>::*block)(std::int32_t)) {
    each_row(home, [](T* mine, T* theirs) { std::memcpy(mine, theirs, 16 * sizeof(T)); }, block, grid);
    std::memset(value + tile_values, 0, 16 * sizeof(T));
  }
  void add_to(Grid<T>& grid, const Home& home, T* (Grid<T>::*block)(std::int32_t)) {
    const auto add = [](T* mine, T* theirs) {
      store_row<T>(theirs, load_row<T>(theirs) + load_row<T>(mine));
    };
    each_row(home, add, block, grid);
  }
};

// The place of a home's tile in units of cells: s = x inv_dx - shift - 4 block.
template <class T>
struct TileFrame {
  T inv_dx;
  T origin[3];

  template <class S>
  static TileFrame of(double dx, BlockCoord at) {
    return {T(1 / dx), {T(4 * at.x) + T(S::shift), T(4 * at.y) + T(S::shift), T(4 * at.z) + T(S::shift)}};
  }
  template <class R>
  R local(R x, int axis) const {
    return x * inv_dx - origin[axis];
  }
};

}  // namespace neve
