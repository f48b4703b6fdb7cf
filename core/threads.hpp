// Threads: OpenMP where the compiler has it, one thread otherwise.
#pragma once

#include <cstddef>
#include <cstdint>

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

// Merge what f(i) returns for each i in [0, n), in parallel; the merge must be one of maxima, whose order does not
// matter.
template <class Out, class F>
Out merge_each(std::size_t n, F&& f) {
  Out total;
#if defined(_OPENMP)
#pragma omp parallel
#endif
  {
    Out mine;
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 4) nowait
#endif
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(n); ++i)
      mine.merge(f(static_cast<std::size_t>(i)));
#if defined(_OPENMP)
#pragma omp critical
#endif
    total.merge(mine);
  }
  return total;
}

// Call f(i) for each i in [0, n), in parallel, in any order.
template <class F>
void each_index(std::size_t n, F&& f) {
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 4)
#endif
  for (std::size_t i = 0; i < n; ++i) f(i);
}

}  // namespace neve
