// Threads: OpenMP where the compiler has it, one thread otherwise.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>

#if defined(_OPENMP)
#include <omp.h>
#endif

namespace neve {

inline int thread_count() {
#if defined(_OPENMP)
  return omp_get_max_threads();
#else
  return 1;
#endif
}

inline void set_thread_count(int n) {
#if defined(_OPENMP)
  omp_set_num_threads(n);
#else
  (void)n;
#endif
}

// Call f(chunk, begin, end) for thread_count() equal chunks of [0, n), in parallel.
template <class F>
void each_chunk(std::size_t n, F&& f) {
  const int chunks = thread_count();
  const auto bound = [&](int c) {
    return n * static_cast<std::size_t>(c) / static_cast<std::size_t>(chunks);
  };
#if defined(_OPENMP)
#pragma omp parallel for schedule(static, 1)
#endif
  for (int c = 0; c < chunks; ++c) f(c, bound(c), bound(c + 1));
}

// The indices [0, n) of a loop, for the threads of a parallel region: each has a share of its own, and helps the others
// when it is done. The k-th thread has the k-th share of every loop over the same homes or blocks, so that it finds them
// in its own cache; one that lost its processor for a while is helped.
class Shares {
 public:
  explicit Shares(std::size_t n)
      : shares_(static_cast<std::size_t>(thread_count())),
        at_once_(std::clamp<std::size_t>(n / (64 * shares_.size()), 1, 64)) {
    for (std::size_t s = 0; s < shares_.size(); ++s) {
      shares_[s].next = n * s / shares_.size();
      shares_[s].end = n * (s + 1) / shares_.size();
    }
  }

  // Call f(i) for each index that no thread has taken yet. Each thread of the region calls this once.
  template <class F>
  void work(F&& f) {
    for (std::size_t k = 0; k < shares_.size(); ++k) {
      Share& share = shares_[(thread() + k) % shares_.size()];
      for (;;) {
        const std::size_t first = share.next.fetch_add(at_once_, std::memory_order_relaxed);
        if (first >= share.end) break;
        for (std::size_t i = first; i < std::min(first + at_once_, share.end); ++i) f(i);
      }
    }
  }

 private:
  struct alignas(64) Share {  // a line of cache of its own
    std::atomic<std::size_t> next{0};
    std::size_t end = 0;
  };
  static std::size_t thread() {
#if defined(_OPENMP)
    return static_cast<std::size_t>(omp_get_thread_num());
#else
    return 0;
#endif
  }
  std::vector<Share> shares_;
  std::size_t at_once_;
};

// Merge what f(i) returns for each i in [0, n), in parallel; the merge must be one of maxima, whose order does not
// matter.
template <class Out, class F>
Out merge_each(std::size_t n, F&& f) {
  Out total;
  Shares shares(n);
#if defined(_OPENMP)
#pragma omp parallel
#endif
  {
    Out mine;
    shares.work([&](std::size_t i) { mine.merge(f(i)); });
#if defined(_OPENMP)
#pragma omp critical
#endif
    total.merge(mine);
  }
  return total;
}

// Call f(i) for each i in [0, n), in parallel, in any order; for few, in this thread alone.
template <class F>
void each_index(std::size_t n, F&& f) {
  Shares shares(n);
#if defined(_OPENMP)
#pragma omp parallel if (n > 4)
#endif
  shares.work(f);
}

}  // namespace neve
