// A home's 8x8x8 nodes in shared memory.
#pragma once

#include "cuda/grid/views.hpp"

namespace neve::cuda {

// The place among all nodes of the n-th node of a home's tile.
inline std::size_t node_of(const Home& home, int n) {
  const int i = n >> 6, j = n >> 3 & 7, k = n & 7;
  const int block = home.nodes[(i >> 2) * 4 + (j >> 2) * 2 + (k >> 2)];
  return std::size_t(block) * block_nodes + std::size_t((i & 3) * 16 + (j & 3) * 4 + (k & 3));
}

// Each thread of a block does its share; a barrier must follow.
template <class T>
inline void clear_tile(Quad<T>* tile) {
  for (int n = int(threadIdx.x); n < tile_nodes; n += int(blockDim.x)) tile[n] = Quad<T>{};
}
template <class T>
inline void load_tile(Quad<T>* tile, const Quad<T>* nodes, const Home& home) {
  for (int n = int(threadIdx.x); n < tile_nodes; n += int(blockDim.x)) tile[n] = nodes[node_of(home, n)];
}

template <class T>
NEVE_INLINE void add_to(Quad<T>& to, const Quad<T>& a) {
  atomicAdd(&to.x, a.x), atomicAdd(&to.y, a.y), atomicAdd(&to.z, a.z), atomicAdd(&to.w, a.w);
}
// Homes share nodes: the sums of their tiles meet in memory.
template <class T>
inline void add_tile(const Quad<T>* tile, Quad<T>* nodes, const Home& home) {
  for (int n = int(threadIdx.x); n < tile_nodes; n += int(blockDim.x)) {
    const Quad<T> a = tile[n];
    if (a.x != T(0) || a.y != T(0) || a.z != T(0) || a.w != T(0)) add_to(nodes[node_of(home, n)], a);
  }
}

}  // namespace neve::cuda
