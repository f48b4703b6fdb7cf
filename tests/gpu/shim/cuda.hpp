// CUDA on the processor, for tests: the very source of the kernels, compiled by any C++ compiler with this file in front.
//
// Blocks run one after another, the threads of a block as fibers that hand over at barriers. In which order threads and
// blocks run is chosen from outside: where a result depends on it, there is a race. A barrier that not all threads of the
// block or warp reach ends the program. Not shown: rounding of the device, divergence within a warp, memory order.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <type_traits>

#include "fibers.hpp"

#define __shared__ static  // one block at a time

namespace shim {

struct Dim {
  unsigned x = 1;
};
inline Dim thread_index, block_index, block_size;

class Block {
 public:
  // order: 0 forward, 1 backward, above it by chance.
  Block(unsigned threads, unsigned order) : fibers_(threads), turns_(permutation(threads, order)) {
    for (Fiber& f : fibers_) f.stack.reset(new char[stack_bytes]);
  }
  static std::vector<unsigned> permutation(unsigned n, unsigned order) {
    std::vector<unsigned> out(n);
    for (unsigned k = 0; k < n; ++k) out[k] = order == 1 ? n - 1 - k : k;
    if (order > 1) std::shuffle(out.begin(), out.end(), std::mt19937(order));
    return out;
  }

  void run(const std::function<void()>& kernel) {
    kernel_ = &kernel, now_ = this;
    block_ = {unsigned(fibers_.size())};
    for (Barrier& w : warps_) w = {};
    for (unsigned t = 0; t < fibers_.size(); ++t) ++warps_[t / 32].members;
    for (Fiber& f : fibers_) f.done = false, f.calls = 0, prepare(f.context, f.stack.get(), &enter, main_);
    for (bool alive = true; alive;) {
      alive = moved_ = false;
      for (unsigned t : turns_) {
        if (fibers_[t].done) continue;
        current_ = t, thread_index.x = t;
        switch_to(main_, fibers_[t].context);
        alive = alive || !fibers_[t].done;
      }
      if (alive && !moved_) fail("threads of a block wait at different barriers");
    }
  }
  static Block& now() { return *now_; }
  void wait_block() { wait(block_); }
  void wait_warp() { wait(warps_[current_ / 32]); }

  // What another lane of the warp calls with. Two slots take turns, so that nobody overwrites what others still read.
  template <class E>
  E from_lane(E mine, unsigned lane) {
    static_assert(sizeof(E) <= 8);
    const unsigned base = current_ & ~31u, slot = fibers_[current_].calls++ % 2;
    __builtin_memcpy(&shown_[slot][current_], &mine, sizeof(E));
    wait_warp();
    E out;
    __builtin_memcpy(&out, &shown_[slot][base + (lane & 31u)], sizeof(E));
    return out;
  }

  [[noreturn]] static void fail(const char* what) {
    std::fprintf(stderr, "shim: %s\n", what);
    std::abort();
  }

 private:
  struct Fiber {
    Context context{};
    std::unique_ptr<char[]> stack;
    bool done = false;
    unsigned calls = 0;
  };
  struct Barrier {
    unsigned members = 0, arrived = 0, round = 0;
  };
  void open_if_full(Barrier& b) {
    if (b.members == 0 || b.arrived < b.members) return;
    b.arrived = 0, ++b.round, moved_ = true;
  }
  void wait(Barrier& b) {
    const unsigned round = b.round, me = current_;
    ++b.arrived;
    open_if_full(b);
    while (b.round == round) {
      switch_to(fibers_[me].context, main_);
    }
  }
  static void enter() {
    Block& b = *now_;
    (*b.kernel_)();
    const unsigned me = b.current_;
    b.fibers_[me].done = b.moved_ = true;
    for (Barrier* barrier : {&b.block_, &b.warps_[me / 32]}) --barrier->members, b.open_if_full(*barrier);
    switch_to(b.fibers_[me].context, b.main_);
  }

  std::vector<Fiber> fibers_;
  std::vector<unsigned> turns_;
  Barrier block_, warps_[32];
  unsigned long long shown_[2][1024];
  unsigned current_ = 0;
  bool moved_ = false;  // some barrier has opened, or some fiber ended, in this round
  Context main_{};
  const std::function<void()>* kernel_ = nullptr;
  static inline Block* now_ = nullptr;
};

inline void launch(const std::function<void()>& kernel, unsigned blocks, unsigned threads, unsigned order) {
  Block block(threads, order);
  block_size.x = threads;
  for (unsigned b : Block::permutation(blocks, order)) {
    block_index.x = b;
    block.run(kernel);
  }
}

}  // namespace shim

#define threadIdx shim::thread_index
#define blockIdx shim::block_index
#define blockDim shim::block_size

inline void __syncthreads() { shim::Block::now().wait_block(); }
inline void __syncwarp() { shim::Block::now().wait_warp(); }
template <class E>
E __shfl_xor_sync(unsigned, E a, int mask) {
  return shim::Block::now().from_lane(a, threadIdx.x ^ unsigned(mask));
}
inline int __ffs(int a) { return __builtin_ffs(a); }

// A thread runs alone until it hands over, so that a plain change is atomic.
template <class E>
E atomicAdd(E* to, std::type_identity_t<E> a) {
  const E before = *to;
  *to = before + a;
  return before;
}
template <class E>
E atomicMax(E* to, std::type_identity_t<E> a) {
  const E before = *to;
  if (a > before) *to = a;
  return before;
}
template <class E>
E atomicOr(E* to, std::type_identity_t<E> a) {
  const E before = *to;
  *to = before | a;
  return before;
}
template <class E>
E atomicCAS(E* to, std::type_identity_t<E> expected, std::type_identity_t<E> a) {
  const E before = *to;
  if (before == expected) *to = a;
  return before;
}
