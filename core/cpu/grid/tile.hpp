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
  // Call f(pointer into the tile, pointer into the node block) for each row of four nodes; `at` gives node blocks by their
  // index.
  template <class F, class At>
  void each_row(const Home& home, F&& f, At&& at) {
    for (int k = 0; k < 8; ++k) {
      const std::int32_t b = home.nodes[static_cast<std::size_t>(k)];
      if (b == BlockMap::none) continue;  // of a sleeper: nobody looks at it
      T* nodes = at(b);
      T* corner = value + (((k >> 2) * 4 * tile_width + ((k >> 1) & 1) * 4) * tile_width + (k & 1) * 4) * 4;
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j)
          f(corner + (i * tile_width + j) * tile_width * 4, nodes + (i * 4 + j) * 16);
      }
    }
  }
  template <class At>
  void load_from(const Home& home, At&& at) {
    each_row(home, [](T* mine, T* theirs) { std::memcpy(mine, theirs, 16 * sizeof(T)); }, at);
    std::memset(value + tile_values, 0, 16 * sizeof(T));
  }
  template <class At>
  void add_to(const Home& home, At&& at) {
    const auto add = [](T* mine, T* theirs) {
      store_row<T>(theirs, load_row<T>(theirs) + load_row<T>(mine));
    };
    each_row(home, add, at);
  }
  void load_from(Grid<T>& grid, const Home& home, T* (Grid<T>::*block)(std::int32_t)) {
    load_from(home, [&](std::int32_t b) { return (grid.*block)(b); });
  }
  void add_to(Grid<T>& grid, const Home& home, T* (Grid<T>::*block)(std::int32_t)) {
    add_to(home, [&](std::int32_t b) { return (grid.*block)(b); });
  }
};

// The place of a home's tile. In it a particle is known by its way from the tile's first node: far from the origin the
// difference of a position and that node is exact in float32, where a position in units of cells is not.
template <class T>
struct TileFrame {
  T inv_dx, shift;
  Vec3<T> corner, beyond;  // the first node is at corner + beyond [m]

  template <class S>
  static TileFrame of(double dx, BlockCoord at) {
    TileFrame frame{T(1 / dx), T(S::shift), {}, {}};
    const Vec3<double> first = first_node(dx, at);
    for (int a = 0; a < 3; ++a)
      frame.corner[a] = T(first[a]), frame.beyond[a] = T(first[a] - double(frame.corner[a]));
    return frame;
  }
  // s = x / dx - shift - 4 block of a way along an axis [cells].
  template <class R>
  R local(R way) const {
    return way * inv_dx - shift;
  }
};

}  // namespace neve
