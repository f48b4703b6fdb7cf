// Maxima over the threads of a block.
#pragma once

#include "cuda/grid/views.hpp"

namespace neve::cuda {

inline constexpr unsigned all_lanes = 0xffffffffu;
inline constexpr int warp = 32;

// A number that is the larger the larger `a` is, and above 0.
inline BlockKey ordered(double a) {
  BlockKey bits;
  std::memcpy(&bits, &a, sizeof(bits));
  constexpr BlockKey sign = BlockKey(1) << 63;
  return bits & sign ? ~bits : bits | sign;
}

template <class T>
NEVE_INLINE T warp_max(T a) {
  for (int far = warp / 2; far > 0; far /= 2) {
    const T other = __shfl_xor_sync(all_lanes, a, far);
    a = other > a ? other : a;
  }
  return a;
}

// Each of N numbers becomes the largest over the block, in thread 0. All threads of the block must come.
template <int Threads, int N, class T>
inline void block_max(T (&a)[N]) {
  static_assert(Threads % warp == 0);
  __shared__ T part[Threads / warp][N];
  for (int k = 0; k < N; ++k) a[k] = warp_max(a[k]);
  if (threadIdx.x % warp == 0) {
    for (int k = 0; k < N; ++k) part[threadIdx.x / warp][k] = a[k];
  }
  __syncthreads();
  if (threadIdx.x == 0) {
    for (int w = 1; w < Threads / warp; ++w) {
      for (int k = 0; k < N; ++k) a[k] = part[w][k] > a[k] ? part[w][k] : a[k];
    }
  }
}

// Tell the host: results.most[first + k] is at least a[k]. One thread of a block does.
template <int N, class T>
inline void publish(Results& results, int first, const T (&a)[N]) {
  for (int k = 0; k < N; ++k) atomicMax(&results.most[first + k], ordered(double(a[k])));
}

}  // namespace neve::cuda
