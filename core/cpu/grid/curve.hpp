// The order of blocks along a curve that fills space, by which the ranks of a run share them out.
#pragma once

#include "mpm/block_key.hpp"

namespace neve {

// Of a block's three numbers of 21 bits the first bits, the second bits, and so on (Morton 1966): blocks that follow each other
// are mostly neighbours, so that a piece of the curve has a small surface.
inline BlockKey curve_of(BlockKey key) {
  const auto apart = [](BlockKey a) {  // a zero and a zero after each bit
    a &= (1u << 21) - 1;
    a = (a | a << 32) & 0x001f00000000ffffull;
    a = (a | a << 16) & 0x001f0000ff0000ffull;
    a = (a | a << 8) & 0x100f00f00f00f00full;
    a = (a | a << 4) & 0x10c30c30c30c30c3ull;
    return (a | a << 2) & 0x1249249249249249ull;
  };
  return apart(key >> 42) << 2 | apart(key >> 21) << 1 | apart(key);
}

}  // namespace neve
