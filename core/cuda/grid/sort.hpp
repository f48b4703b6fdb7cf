// Sort the particles by home block, then by cell, and number the blocks of nodes that the homes' tiles cover.
//
// A table of blocks finds the homes; their keys are sorted, so that neighbours in memory are neighbours in space. In a home,
// particles are ordered by cell, octant and birth number. The order depends on the particles alone, not on which thread
// came first. It runs only when a particle has drifted out of its home's tile.
#pragma once

#include "cuda/grid/reduce.hpp"
#include "cuda/grid/stencil.hpp"
#include "cuda/grid/table.hpp"

namespace neve::cuda {

inline constexpr int sort_threads = 128, scan_threads = 256;

inline unsigned thread_number() { return blockIdx.x * blockDim.x + threadIdx.x; }

// Where particles live: s = x / dx - shift, the home block and the cell in it (as cpu/grid/sort.hpp).
template <class T, class S>
struct Placing {
  T per_dx;
  T lattice(T x) const { return x * per_dx - T(S::shift); }

  // False for a position that is not finite or beyond the lattice.
  bool home(const Vec3<T>& x, BlockKey& key) const {
    std::int32_t b[3];
    for (int k = 0; k < 3; ++k) {
      const T u = lattice(x[k]) - T(S::margin);
      if (!(abs(u) < T(4.0 * (block_limit - 2)))) return false;
      b[k] = std::int32_t(floor(u * T(0.25)));
    }
    key = key_of({b[0], b[1], b[2]});
    return true;
  }
  // The cell, and within it the octant by a Gray code: whoever has crossed to the next cell still has its neighbours.
  unsigned cell(const Vec3<T>& x, const BlockCoord& at) const {
    constexpr int cells = 5, low = int(S::margin);
    const std::int32_t origin[3] = {at.x, at.y, at.z};
    int c = 0, upper[3];
    for (int k = 0; k < 3; ++k) {
      const T u = lattice(x[k]) - T(4 * origin[k]);
      const int base = clamp(int(u), low, low + cells - 1);
      upper[k] = u - T(base) >= T(0.5);
      c = c * cells + base - low;
    }
    return unsigned(c * 8 + 4 * upper[2] + 2 * (upper[2] ^ upper[0]) + (upper[2] ^ upper[0] ^ upper[1]));
  }
};
template <class C>
inline auto placing_of(const Step<typename C::T>& s) {
  return Placing<typename C::T, typename C::Spline>{s.constants.step.cells.gradient};
}

template <class T>
inline Vec3<T> position(const Step<T>& s, unsigned p) {
  return {s.particles.x[0][p], s.particles.x[1][p], s.particles.x[2][p]};
}

// 1. A thread per particle: put the key of its home into the table; find the lightest particle.
template <class C>
inline void find_homes(const Step<typename C::T>& s) {
  using T = typename C::T;
  const unsigned p = thread_number();
  T less[1] = {-std::numeric_limits<T>::max()};
  if (p < s.particle_count) {
    less[0] = -s.particles.m[p];
    BlockKey key;
    if (placing_of<C>(s).home(position(s, p), key)) {
      const int slot = insert(s.sorting.homes, key);
      s.sorting.home_of[p] = slot;
      if (slot < 0) s.results->full = 1;
    } else {
      atomicMax(&s.results->lost, ~s.particles.id[p]);
    }
  }
  block_max<sort_threads>(less);
  if (threadIdx.x == 0) publish(*s.results, less_mass, less);
}

// One comparison of a bitonic sort of n keys: the first pass of a run of `width` meets the run turned round (span is
// width - 1), the others meet it shifted by `span`. What would lie beyond the end is the largest, and stays there.
inline bool partner_of(unsigned i, unsigned span, unsigned n, unsigned& partner) {
  partner = i ^ span;
  return partner > i && partner < n;
}

// 2. Passes over the keys of the homes, a thread per key.
template <class T>
inline void sort_homes(const Step<T>& s) {
  const unsigned i = thread_number();
  unsigned j;
  if (i >= s.home_count || !partner_of(i, s.sorting.span, s.home_count, j)) return;
  BlockKey* list = s.sorting.homes.list;
  const BlockKey a = list[i], b = list[j];
  if (b < a) list[i] = b, list[j] = a;
}

// 3. A thread per home: its number is its rank.
template <class T>
inline void rank_homes(const Step<T>& s) {
  const unsigned h = thread_number();
  if (h >= s.home_count) return;
  const BlockKey key = s.sorting.homes.list[h];
  s.sorting.homes.value[slot_of(s.sorting.homes, key)] = int(h);
  s.nodes.homes[h].at = coord_of(key);
  s.nodes.homes[h].count = 0;
}

// 4. A thread per particle.
template <class T>
inline void count_homes(const Step<T>& s) {
  const unsigned p = thread_number();
  if (p >= s.particle_count) return;
  const int h = s.sorting.homes.value[s.sorting.home_of[p]];
  s.sorting.home_of[p] = h;
  s.sorting.place[p] = atomicAdd(&s.nodes.homes[h].count, 1u);
}

// 5. One block: where each home begins.
template <class T>
inline void scan_homes(const Step<T>& s) {
  __shared__ unsigned sums[scan_threads];
  unsigned before = 0;
  for (unsigned first = 0; first < s.home_count; first += scan_threads) {
    const unsigned h = first + threadIdx.x, mine = h < s.home_count ? s.nodes.homes[h].count : 0;
    sums[threadIdx.x] = mine;
    __syncthreads();
    for (unsigned far = 1; far < scan_threads; far *= 2) {
      const unsigned other = threadIdx.x >= far ? sums[threadIdx.x - far] : 0;
      __syncthreads();
      sums[threadIdx.x] += other;
      __syncthreads();
    }
    if (h < s.home_count) s.nodes.homes[h].begin = before + sums[threadIdx.x] - mine;
    before += sums[scan_threads - 1];
    __syncthreads();
  }
}

// 6. A thread per particle: a place in its home, whichever, and the key that decides about the place.
template <class C>
inline void place_particles(const Step<typename C::T>& s) {
  const unsigned p = thread_number();
  if (p >= s.particle_count) return;
  const Home& home = s.nodes.homes[s.sorting.home_of[p]];
  const unsigned at = home.begin + s.sorting.place[p];
  s.sorting.order[at] = p;
  s.sorting.key[at] = BlockKey(placing_of<C>(s).cell(position(s, p), home.at)) << 32 | s.particles.id[p];
}

// 7. A block per home: order its particles by their keys.
template <class T>
inline void order_homes(const Step<T>& s) {
  const Home& home = s.nodes.homes[blockIdx.x];
  BlockKey* key = s.sorting.key + home.begin;
  unsigned* order = s.sorting.order + home.begin;
  const auto pass = [&](unsigned span) {
    for (unsigned i = threadIdx.x; i < home.count; i += blockDim.x) {
      unsigned j;
      if (!partner_of(i, span, home.count, j) || key[i] <= key[j]) continue;
      const BlockKey k = key[i];
      key[i] = key[j], key[j] = k;
      const unsigned p = order[i];
      order[i] = order[j], order[j] = p;
    }
    __syncthreads();
  };
  for (unsigned run = 2; run / 2 < home.count; run *= 2) {
    pass(run - 1);
    for (unsigned span = run / 4; span > 0; span /= 2) pass(span);
  }
}

// 8. A thread per particle, for one column after another.
template <class T>
inline void permute(const Step<T>& s) {
  const unsigned i = thread_number();
  if (i >= s.particle_count) return;
  const unsigned p = s.sorting.order[i];
  const auto move = [&](auto zero) {
    using E = decltype(zero);
    static_cast<E*>(s.sorting.to)[i] = static_cast<const E*>(s.sorting.from)[p];
  };
  if (s.sorting.width == 2) move(static_cast<unsigned short>(0));
  if (s.sorting.width == 4) move(0u);
  if (s.sorting.width == 8) move(BlockKey(0));
}

// 9. A thread per corner of a home's tile.
template <class T>
inline void find_blocks(const Step<T>& s) {
  const unsigned n = thread_number();
  if (n >= 8 * s.home_count) return;
  const BlockCoord at = s.nodes.homes[n / 8].at;
  const int k = int(n % 8);
  const int slot = insert(s.sorting.blocks, key_of({at.x + (k >> 2), at.y + (k >> 1 & 1), at.z + (k & 1)}));
  s.nodes.homes[n / 8].nodes[k] = slot;
  if (slot < 0) s.results->full = 1;
}

// 10. A thread per corner of a home's tile, and thereby one at least per block.
template <class T>
inline void link_homes(const Step<T>& s) {
  const unsigned n = thread_number();
  if (n >= 8 * s.home_count) return;
  int& node = s.nodes.homes[n / 8].nodes[n % 8];
  node = s.sorting.blocks.value[node];
  if (n < s.block_count) s.nodes.at[n] = coord_of(s.sorting.blocks.list[n]);
}

}  // namespace neve::cuda
