// From the particles of a warp to the nodes of a tile.
//
// The particles are shown to all lanes in shared memory, and each lane sums over them for nodes of its own. Neighbours in
// memory are mostly of one cell, so that the sums stay in registers until the cell changes (the CPU's Scatter, turned by a
// right angle); only then do they meet those of other warps in the tile.
#pragma once

#include "cuda/grid/reduce.hpp"
#include "cuda/grid/stencil.hpp"
#include "cuda/grid/tile.hpp"

namespace neve::cuda {

// What a particle shows: its weights, and for each mode a vector that its weights multiply, beside the mass of the first.
// Modes are those of transfer/modes.hpp from `From` on; the weights of a mode are products over the axes.
template <class T, class Spline, class Weights, int From, int Modes>
struct Shown {
  Stencil<T, Spline, Weights> at;
  Vec3<T> mode[Modes];
  T mass;
};

template <class T, class Spline, class Weights, int From, int Modes>
struct NodeSums {
  using Given = Shown<T, Spline, Weights, From, Modes>;
  static constexpr int K = Spline::nodes, nodes = K * K * K, each = (nodes + warp - 1) / warp;
  Quad<T> sum[each];
  int cell;

  // Sum the `count` particles shown.
  NEVE_INLINE void add(const Given* shown, int count, Quad<T>* tile) {
    if (count == 0) return;
    clear(shown[0].at.first);
    for (int l = 0; l < count; ++l) {
      const Given& p = shown[l];
      if (p.at.first != cell) {
        flush(tile);
        clear(p.at.first);
      }
      each_node([&](int e, int i, int j, int k) NEVE_INLINE_LAMBDA {
        Vec3<T> q{};
        for (int n = 0; n < Modes; ++n) {
          constexpr auto& order = modes_of<(Weights::count > 2 ? 3 : 2)>;
          const int* d = order[From + n].degree;
          q = q + p.mode[n] * (p.at.w[0][d[0]][i] * p.at.w[1][d[1]][j] * p.at.w[2][d[2]][k]);
        }
        Quad<T>& to = sum[e];
        to.x += q.x, to.y += q.y, to.z += q.z;
        if constexpr (From == 0) to.w += p.at.w[0][0][i] * p.at.w[1][0][j] * p.at.w[2][0][k] * p.mass;
      });
    }
    flush(tile);
  }

 private:
  template <class F>
  NEVE_INLINE void each_node(F&& f) {
    for (int e = 0; e < each; ++e) {
      const int n = int(threadIdx.x % warp) + warp * e;
      if (n < nodes) f(e, n / (K * K), n / K % K, n % K);
    }
  }
  NEVE_INLINE void clear(int first) {
    for (Quad<T>& q : sum) q = Quad<T>{};
    cell = first;
  }
  NEVE_INLINE void flush(Quad<T>* tile) {
    each_node([&](int e, int i, int j, int k)
                  NEVE_INLINE_LAMBDA { add_to(tile[cell + node_after(i, j, k)], sum[e]); });
    __syncwarp();  // cells share nodes, which other lanes sum for
  }
};

// Sum what the lanes of a warp give into the tile, a few particles at a time where they are large. All lanes must come;
// the first `count` of them have a particle.
template <int Slots, class Given, class Sums, class T>
NEVE_INLINE void scatter(const Given& mine, int count, Given* shown, Quad<T>* tile) {
  const int lane = int(threadIdx.x % warp);
  Sums sums;
  for (int first = 0; first < warp; first += Slots) {
    if (lane >= first && lane < first + Slots) shown[lane - first] = mine;
    __syncwarp();
    sums.add(shown, clamp(count - first, 0, Slots), tile);
    __syncwarp();
  }
}

// How many particles a warp shows at a time: all, if what they show leaves room for four warps beside so many tiles.
inline constexpr std::size_t shared_bytes = 48 * 1024;  // that any device has without being asked
template <class T>
constexpr int slots_for(std::size_t shown_bytes, std::size_t tiles) {
  int slots = warp;
  while (slots > 1 && 4 * slots * shown_bytes + tiles * tile_nodes * sizeof(Quad<T>) > shared_bytes)
    slots /= 2;
  return slots;
}

}  // namespace neve::cuda
