// Sort the particles by home block, then by cell, and lay out the blocks.
//
// A stable counting sort: its result depends on the particles alone, not on the number of threads. It runs only when
// a particle has drifted out of its home's tile (every few to tens of steps).
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "cpu/grid/grid.hpp"
#include "mpm/dispatch.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

// Where particle p lives: s = x / dx - shift, its home block and its cell in the block.
template <class T>
struct Placing {
  T inv_dx, shift, margin;
  int first;  // lowest cell of a home's particles when sorted

  T lattice(T x) const { return x * inv_dx - shift; }
  static std::int32_t block(T u) { return static_cast<std::int32_t>(std::floor(u * T(0.25))); }
  // false for a position that is not finite or beyond the lattice
  bool home(const State<T>& s, std::size_t p, BlockKey& key) const {
    std::int32_t b[3];
    for (int k = 0; k < 3; ++k) {
      const T u = lattice(s.x.column(k)[p]) - margin;
      if (!(std::abs(u) < T(4.0 * (block_limit - 2)))) return false;
      b[k] = block(u);
    }
    key = key_of({b[0], b[1], b[2]});
    return true;
  }
  // The cell, and within it the octant, z slowest and turning back at each end (a Gray code): when snow drifts out of
  // its cell between two sorts, mostly downward, the particles that have crossed are still neighbours in memory.
  static constexpr int cells = 5, octants = 8, keys = cells * cells * cells * octants;
  int cell(const State<T>& s, std::size_t p, BlockCoord at) const {
    const std::int32_t origin[3] = {at.x, at.y, at.z};
    int c = 0, upper[3];
    for (int k = 0; k < 3; ++k) {
      const T u = lattice(s.x.column(k)[p]) - T(4 * origin[k]);
      const int base = std::clamp(static_cast<int>(u), first, first + cells - 1);
      upper[k] = u - T(base) >= T(0.5);
      c = c * cells + base - first;
    }
    return c * octants + 4 * upper[2] + 2 * (upper[2] ^ upper[0]) + (upper[2] ^ upper[0] ^ upper[1]);
  }
};

template <class T>
Placing<T> placing_of(const Model<T>& model) {
  return with_spline(model.spline, [&](auto spline) {
    using S = decltype(spline);
    return Placing<T>{T(1 / model.dx), T(S::shift), T(S::margin), static_cast<int>(S::margin)};
  });
}

// Let `first` be the lost particle of the lowest birth number so far, of which p is one; -1: there was none.
template <class T>
void note_lost(const State<T>& state, std::size_t p, std::int64_t& first) {
  if (first < 0 || state.id[p] < state.id[static_cast<std::size_t>(first)])
    first = static_cast<std::int64_t>(p);
}

// Name the lost particle of the lowest birth number, the same for any number of threads.
template <class T>
void throw_if_lost(const State<T>& state, const std::vector<std::int64_t>& lost) {
  std::int64_t first = -1;
  for (std::int64_t p : lost) {
    if (p >= 0) note_lost(state, static_cast<std::size_t>(p), first);
  }
  if (first < 0) return;
  const auto p = static_cast<std::size_t>(first);
  std::string where;
  for (int k = 0; k < 3; ++k) where += (k ? ", " : "") + std::to_string(state.x.column(k)[p]);
  throw std::domain_error("particle " + std::to_string(state.id[p]) + " at (" + where +
                          ") m is beyond the lattice");
}

// The keys of the homes of the first `count` particles, in rising order; grid.home_of[p] becomes the rank of p's home.
template <class T>
std::vector<BlockKey> find_homes(const State<T>& state, std::size_t count, const Placing<T>& placing,
                                 Grid<T>& grid) {
  const int threads = thread_count();
  std::vector<BlockMap> maps(static_cast<std::size_t>(threads));
  std::vector<std::int64_t> lost(static_cast<std::size_t>(threads), -1);
  grid.home_of.resize(count);
  each_chunk(count, [&](int chunk, std::size_t begin, std::size_t end) {
    BlockMap& map = maps[static_cast<std::size_t>(chunk)];
    BlockKey last = ~BlockKey(0), key = 0;
    std::int32_t index = 0;
    for (std::size_t p = begin; p < end; ++p) {
      if (!placing.home(state, p, key)) {
        note_lost(state, p, lost[static_cast<std::size_t>(chunk)]);
        continue;
      }
      if (key != last) index = map.insert(key), last = key;
      grid.home_of[p] = index;
    }
  });
  throw_if_lost(state, lost);
  std::vector<BlockKey> keys;
  for (const BlockMap& map : maps) keys.insert(keys.end(), map.keys().begin(), map.keys().end());
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  each_chunk(count, [&](int chunk, std::size_t begin, std::size_t end) {
    const auto& local = maps[static_cast<std::size_t>(chunk)].keys();
    std::vector<std::int32_t> rank(local.size());
    for (std::size_t k = 0; k < local.size(); ++k) {
      rank[k] =
          static_cast<std::int32_t>(std::lower_bound(keys.begin(), keys.end(), local[k]) - keys.begin());
    }
    for (std::size_t p = begin; p < end; ++p) {
      grid.home_of[p] = rank[static_cast<std::size_t>(grid.home_of[p])];
    }
  });
  return keys;
}

// Fill grid.order with the first particles by home, and the homes' ranges.
template <class T>
void order_by_home(std::size_t particles, const std::vector<BlockKey>& keys, Grid<T>& grid) {
  const std::size_t homes = keys.size();
  const auto threads = static_cast<std::size_t>(thread_count());
  std::vector<std::uint32_t> next(threads * homes, 0);
  each_chunk(particles, [&](int chunk, std::size_t begin, std::size_t end) {
    std::uint32_t* count = next.data() + static_cast<std::size_t>(chunk) * homes;
    for (std::size_t p = begin; p < end; ++p) ++count[grid.home_of[p]];
  });
  grid.homes.resize(homes);
  std::uint32_t at = 0;
  for (std::size_t h = 0; h < homes; ++h) {
    grid.homes[h].at = coord_of(keys[h]);
    grid.homes[h].begin = at;
    for (std::size_t t = 0; t < threads; ++t) {
      const std::uint32_t n = next[t * homes + h];
      next[t * homes + h] = at;
      at += n;
    }
    grid.homes[h].count = at - grid.homes[h].begin;
  }
  grid.order.resize(particles);
  each_chunk(particles, [&](int chunk, std::size_t begin, std::size_t end) {
    std::uint32_t* slot = next.data() + static_cast<std::size_t>(chunk) * homes;
    for (std::size_t p = begin; p < end; ++p) {
      grid.order[slot[grid.home_of[p]]++] = static_cast<std::uint32_t>(p);
    }
  });
}

// Put the rows of a home into the order in which one rank would find them.
inline void restore_order(const EarlierOrder& earlier, std::vector<std::uint32_t>& rows) {
  if (earlier.home.empty()) return;
  if (std::none_of(rows.begin(), rows.end(), [&](std::uint32_t p) { return earlier.is_disturbed(p); }))
    return;
  std::sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(earlier.home[a], earlier.row[a]) < std::pair(earlier.home[b], earlier.row[b]);
  });
}

// Within each home, order by cell: neighbours in memory then share a stencil.
template <class T>
void order_by_cell(const State<T>& state, const Placing<T>& placing, Grid<T>& grid) {
  each_index(grid.homes.size(), [&](std::size_t h) {
    const Home& home = grid.homes[h];
    std::array<std::uint32_t, Placing<T>::keys + 1> next{};
    std::vector<std::uint16_t> cell(home.count);
    std::vector<std::uint32_t> before(grid.order.begin() + home.begin,
                                      grid.order.begin() + home.begin + home.count);
    restore_order(grid.earlier, before);
    for (std::uint32_t k = 0; k < home.count; ++k) {
      cell[k] = static_cast<std::uint16_t>(placing.cell(state, before[k], home.at));
      ++next[cell[k] + 1u];
    }
    for (std::size_t c = 1; c < next.size(); ++c) next[c] += next[c - 1];
    for (std::uint32_t k = 0; k < home.count; ++k) grid.order[home.begin + next[cell[k]]++] = before[k];
  });
}

// Move every column into the new order, one at a time through one spare column: addresses stay valid.
template <class T>
void permute(State<T>& state, Grid<T>& grid) {
  const std::size_t count = grid.order.size();
  if (grid.spare.size() < count * sizeof(double)) grid.spare.resize(count * sizeof(double));
  state.each_column([&](auto* column) {
    auto* spare = reinterpret_cast<decltype(column)>(grid.spare.data());
    each_chunk(count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) spare[p] = column[grid.order[p]];
    });
    each_chunk(count, [&](int, std::size_t begin, std::size_t end) {
      std::memcpy(column + begin, spare + begin, (end - begin) * sizeof(*column));
    });
  });
}

// Allocate the node blocks that the tiles of homes that move cover, and find the turns of the homes.
template <class T>
void lay_out_blocks(Grid<T>& grid) {
  BlockMap map(grid.homes.size() * 2 + 8);
  for (std::size_t h = 0; h < grid.moving; ++h) {
    for (int k = 0; k < 8; ++k) map.insert(tile_block(grid.homes[h].at, k));
  }
  const std::size_t n = map.keys().size();
  std::vector<std::int32_t> by_key(n), rank(n);
  for (std::size_t k = 0; k < n; ++k) by_key[k] = static_cast<std::int32_t>(k);
  std::sort(by_key.begin(), by_key.end(), [&](std::int32_t a, std::int32_t b) {
    return map.keys()[static_cast<std::size_t>(a)] < map.keys()[static_cast<std::size_t>(b)];
  });
  grid.blocks.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const auto old = static_cast<std::size_t>(by_key[k]);
    rank[old] = static_cast<std::int32_t>(k);
    grid.blocks[k] = coord_of(map.keys()[old]);
  }
  for (Home& home : grid.homes) {
    for (int k = 0; k < 8; ++k) {
      const std::int32_t found = map.find(tile_block(home.at, k));
      home.nodes[static_cast<std::size_t>(k)] =
          found == BlockMap::none ? found : rank[static_cast<std::size_t>(found)];
    }
  }
  if (!grid.halo.shares) grid.turns.lay_out(grid.homes, false);  // else lay_halo() does
}

// Make room for what a step keeps of the blocks and homes that there are.
template <class T>
void make_room(const Model<T>& model, const State<T>& state, Grid<T>& grid) {
  const std::size_t values = grid.blocks.size() * block_values;
  grid.has_change = keeps_change(model), grid.has_lift = has_play(model);
  if (grid.momentum.size() < values) grid.momentum.resize(values + values / 4);
  if (grid.has_change && grid.change.size() < values) grid.change.resize(values + values / 4);
  grid.has_water = model.heat.has_value();
  if ((grid.has_lift || grid.has_water) && grid.lift.size() < values) grid.lift.resize(values + values / 4);
  grid.bounds.resize(grid.blocks.size());
  grid.node_exchange.resize(grid.blocks.size());
  grid.particle_exchange.resize(grid.moving);
  if (model.sleeps()) grid.drift.resize(grid.moving);
  grid.lightest = grid.awake ? *std::min_element(state.m.column(0), state.m.column(0) + grid.awake) : T(0);
  grid.count = state.count;
}

}  // namespace detail

}  // namespace neve
