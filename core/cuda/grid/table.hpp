// The hash table of blocks: 64-bit keys, linear probing, numbers by an atomic counter.
#pragma once

#include "cuda/grid/views.hpp"

namespace neve::cuda {

// So far a key is looked for: a table that is half full at most has no such chains, but by bad luck. Then it is enlarged.
inline constexpr unsigned longest_chain = 128;

// The slot of a key, which gets the next number if it is new; -1 if the table is too full.
inline int insert(const Table& table, BlockKey key) {
  const unsigned last = table.capacity - 1;
  unsigned i = unsigned(scattered(key) >> table.shift);
  for (unsigned k = 0; k < longest_chain; ++k, i = (i + 1) & last) {
    BlockKey there = table.keys[i];
    if (there == no_key) {
      there = atomicCAS(&table.keys[i], no_key, key);
      if (there == no_key) {
        const unsigned number = atomicAdd(table.count, 1u);
        if (2 * number >= table.capacity) return -1;
        table.value[i] = int(number);
        table.list[number] = key;
        return int(i);
      }
    }
    if (there == key) return int(i);
  }
  return -1;
}

// The slot of a key that is there.
inline int slot_of(const Table& table, BlockKey key) {
  const unsigned last = table.capacity - 1;
  unsigned i = unsigned(scattered(key) >> table.shift);
  while (table.keys[i] != key) i = (i + 1) & last;
  return int(i);
}

}  // namespace neve::cuda
