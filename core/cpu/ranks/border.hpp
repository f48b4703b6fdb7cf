// Which homes of a rank give to nodes of others, and which blocks of nodes are given and taken.
//
// Rank r owns the blocks from cuts[r - 1] up to cuts[r] along the curve. Two ranks tell each other of their homes that are beside a
// block of the other's; from both lists each finds the same blocks, in the same order.
#pragma once

#include <algorithm>
#include <utility>

#include "cpu/grid/curve.hpp"
#include "cpu/grid/grid.hpp"

namespace neve {

inline std::int32_t owner_of(const std::vector<BlockKey>& cuts, BlockKey key) {
  return static_cast<std::int32_t>(std::upper_bound(cuts.begin(), cuts.end(), curve_of(key)) - cuts.begin());
}

// The homes of this rank that are beside a block of another: by rank, then by key.
template <class T>
std::vector<std::pair<std::int32_t, BlockKey>> border_of(const Grid<T>& grid,
                                                         const std::vector<BlockKey>& cuts,
                                                         std::int32_t rank) {
  std::vector<std::pair<std::int32_t, BlockKey>> out;
  for (std::size_t h = 0; h < grid.moving; ++h) {
    const BlockCoord at = grid.homes[h].at;
    std::vector<std::int32_t> others;
    for (int n = 0; n < 27; ++n) {
      const std::int32_t r =
          owner_of(cuts, key_of({at.x + n / 9 - 1, at.y + n / 3 % 3 - 1, at.z + n % 3 - 1}));
      if (r != rank && std::find(others.begin(), others.end(), r) == others.end()) others.push_back(r);
    }
    for (std::int32_t r : others) out.emplace_back(r, key_of(at));
  }
  std::sort(out.begin(), out.end());
  return out;
}

// A rank that this one shares nodes with: homes at the border of this one and of that one, by rising key.
struct Neighbour {
  bool is_lower;
  std::vector<BlockKey> mine, theirs;
};

namespace detail {

// What one neighbour is given and gives.
template <class T>
void meet(const Neighbour& other, BlockMap& mine_at, BlockMap& blocks_at, Halo<T>& halo) {
  BlockMap theirs(other.theirs.size() * 16 + 8);
  for (BlockKey home : other.theirs) {
    for (int k = 0; k < 8; ++k) theirs.insert(tile_block(coord_of(home), k));
  }
  for (BlockKey home : other.mine) {
    const std::int32_t h = mine_at.find(home);
    for (int k = 0; k < 8; ++k) {
      if (theirs.find(tile_block(coord_of(home), k)) == BlockMap::none) continue;
      auto& place = halo.kept_of[std::size_t(h)];
      if (place == BlockMap::none) {
        place = static_cast<std::int32_t>(halo.border.size());
        halo.border.push_back(h);
      }
      halo.given.push_back(8 * place + k);
    }
  }
  for (BlockKey home : other.theirs) {
    for (int k = 0; k < 8; ++k) {
      const std::int32_t b = blocks_at.find(tile_block(coord_of(home), k));
      if (b == BlockMap::none) continue;
      halo.taken_of[std::size_t(colour_of(coord_of(home)))].push_back(
          static_cast<std::int32_t>(halo.taken.size()));
      halo.taken.push_back(b);
      if (other.is_lower) halo.counted[std::size_t(b)] = 0;
    }
  }
}

}  // namespace detail

// Lay out the halo of a grid that has just been sorted. The numbers of blocks given to and taken from each neighbour, in their
// order.
template <class T>
std::vector<std::pair<std::size_t, std::size_t>> lay_halo(Grid<T>& grid,
                                                          const std::vector<Neighbour>& neighbours) {
  Halo<T>& halo = grid.halo;
  halo.shares = true;
  grid.turns.lay_out(grid.homes, true);
  halo.border.clear(), halo.given.clear(), halo.taken.clear();
  for (auto& rows : halo.taken_of) rows.clear();
  halo.kept_of.assign(grid.homes.size(), BlockMap::none);
  halo.counted.assign(grid.blocks.size(), 1);
  BlockMap mine_at(grid.homes.size() + 8), blocks_at(grid.blocks.size() + 8);
  for (const Home& home : grid.homes) mine_at.insert(key_of(home.at));
  for (BlockCoord at : grid.blocks) blocks_at.insert(key_of(at));
  std::vector<std::pair<std::size_t, std::size_t>> counts;
  for (const Neighbour& other : neighbours) {
    const std::size_t given = halo.given.size(), taken = halo.taken.size();
    detail::meet(other, mine_at, blocks_at, halo);
    counts.emplace_back(halo.given.size() - given, halo.taken.size() - taken);
  }
  const std::size_t values = std::size_t(grid.layers()) * block_values;
  const auto make_room = [](Column<T>& column, std::size_t n) {
    if (column.size() < n) column.resize(n + n / 4);
  };
  make_room(halo.kept, halo.border.size() * 8 * values);
  make_room(halo.sent, halo.given.size() * values);
  make_room(halo.received, halo.taken.size() * values);
  return counts;
}

}  // namespace neve
