// Maxima and sums over the threads of a block.
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

// Each of N numbers becomes join(a, b) of those of all threads, in thread 0. All threads of the block must come.
template <int Threads, int N, class T, class F>
NEVE_INLINE void block_join(T (&a)[N], F&& join) {
  static_assert(Threads % warp == 0);
  __shared__ T part[Threads / warp][N];
  for (int k = 0; k < N; ++k) {
    for (int far = warp / 2; far > 0; far /= 2) a[k] = join(a[k], __shfl_xor_sync(all_lanes, a[k], far));
  }
  if (threadIdx.x % warp == 0) {
    for (int k = 0; k < N; ++k) part[threadIdx.x / warp][k] = a[k];
  }
  __syncthreads();
  if (threadIdx.x == 0) {
    for (int w = 1; w < Threads / warp; ++w) {
      for (int k = 0; k < N; ++k) a[k] = join(a[k], part[w][k]);
    }
  }
}
template <int Threads, int N, class T>
inline void block_max(T (&a)[N]) {
  block_join<Threads>(a, [](T b, T c) { return c > b ? c : b; });
}
template <int Threads, int N, class T>
inline void block_sum(T (&a)[N]) {
  block_join<Threads>(a, [](T b, T c) { return b + c; });
}

// Tell the host: results.most[first + k] is at least a[k]. One thread of a block does.
template <int N, class T>
inline void publish(Results& results, int first, const T (&a)[N]) {
  for (int k = 0; k < N; ++k) atomicMax(&results.most[first + k], ordered(double(a[k])));
}

}  // namespace neve::cuda
