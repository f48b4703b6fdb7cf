// Where blocks of 4x4x4 nodes lie, in a domain without bounds.
//
// Two kinds of blocks share one lattice. A *home* is the block that owns a particle; the particle's stencil may
// reach into the home's seven upper neighbours, so each home reads and writes a tile of 2x2x2 node blocks, 8x8x8
// nodes. A *node block* stores 64 nodes of four numbers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mpm/block_key.hpp"

namespace neve {

// Key -> index, by open addressing.
class BlockMap {
 public:
  static constexpr std::int32_t none = -1;

  explicit BlockMap(std::size_t expected = 64) { rehash(expected * 2); }

  // The index of the key; a new key gets the next free index.
  std::int32_t insert(BlockKey key) {
    if ((keys_.size() + 1) * 2 > slots_.size()) rehash(slots_.size() * 2);
    std::int32_t& slot = find_slot(key);
    if (slot == none) {
      slot = static_cast<std::int32_t>(keys_.size());
      keys_.push_back(key);
    }
    return slot;
  }
  std::int32_t find(BlockKey key) { return find_slot(key); }
  const std::vector<BlockKey>& keys() const { return keys_; }

 private:
  std::int32_t& find_slot(BlockKey key) {
    std::size_t i = scattered(key) >> shift_;
    while (slots_[i] != none && keys_[static_cast<std::size_t>(slots_[i])] != key)
      i = (i + 1) & (slots_.size() - 1);
    return slots_[i];
  }
  void rehash(std::size_t wanted) {
    int bits = 6;
    while ((std::size_t(1) << bits) < wanted) ++bits;
    shift_ = 64 - bits;
    slots_.assign(std::size_t(1) << bits, none);
    for (std::size_t k = 0; k < keys_.size(); ++k) find_slot(keys_[k]) = static_cast<std::int32_t>(k);
  }
  std::vector<BlockKey> keys_;
  std::vector<std::int32_t> slots_;
  int shift_ = 0;
};

// A home: the particles [begin, begin + count) and the eight node blocks of its tile, index 4 dx + 2 dy + dz.
struct Home {
  BlockCoord at;
  std::uint32_t begin, count;
  std::array<std::int32_t, 8> nodes;
};

// The k-th node block of a home's tile, in the order of Home::nodes.
inline BlockKey tile_block(BlockCoord home, int k) {
  return key_of({home.x + (k >> 2), home.y + ((k >> 1) & 1), home.z + (k & 1)});
}

// Which of eight: tiles of homes of one colour never overlap.
inline int colour_of(BlockCoord at) { return (at.x & 1) * 4 + (at.y & 1) * 2 + (at.z & 1); }

// Where the first node of a block is [m].
inline Vec3<double> first_node(double dx, BlockCoord at) {
  return {4.0 * at.x * dx, 4.0 * at.y * dx, 4.0 * at.z * dx};
}

}  // namespace neve
