// Small functions of packs must be inlined: a call passes every register through memory. Compilers weigh a pack of two
// registers as twice the code and stop too early.
#pragma once

#if defined(__CUDACC_RTC__)
#define NEVE_INLINE __forceinline__
#define NEVE_INLINE_LAMBDA
// What is seldom needed is part of its caller here all the same: a call of a kernel hands matrices over on a stack in
// memory and keeps its caller's registers there, and a kernel that calls needs that stack for every thread. A branch that no
// thread of a warp takes costs one comparison.
#define NEVE_RARE __forceinline__
#define NEVE_UNROLL _Pragma("unroll")  // loops that must leave no index, so that arrays become registers
#else
#define NEVE_INLINE [[gnu::always_inline]] inline
#define NEVE_INLINE_LAMBDA __attribute__((always_inline))  // between the parameters and the body
#define NEVE_UNROLL
#define NEVE_RARE [[gnu::noinline, gnu::cold]] inline  // what is seldom called stays out of the way
// What must give the same bits to all who call it: part of a caller, a product might be fused with another sum.
#define NEVE_APART [[gnu::noinline]]
#endif
