// The name of a block of 4x4x4 nodes, in a domain without bounds.
#pragma once

#include "math/standard.hpp"

namespace neve {

struct BlockCoord {
  std::int32_t x, y, z;
};

// 21 bits an axis: +-2^20 blocks, so 4 million cells each way from the origin.
inline constexpr std::int32_t block_limit = 1 << 20;
using BlockKey = unsigned long long;

inline BlockKey key_of(BlockCoord b) {
  const auto u = [](std::int32_t a) { return static_cast<BlockKey>(a + block_limit); };
  return (u(b.x) << 42) | (u(b.y) << 21) | u(b.z);
}
inline BlockCoord coord_of(BlockKey key) {
  const auto i = [](BlockKey a) { return static_cast<std::int32_t>(a & ((1u << 21) - 1)) - block_limit; };
  return {i(key >> 42), i(key >> 21), i(key)};
}

// The key with its bits mixed: the upper ones say where a hash table looks first (Fibonacci hashing, Knuth).
inline BlockKey scattered(BlockKey key) { return key * 0x9E3779B97F4A7C15ull; }

}  // namespace neve
