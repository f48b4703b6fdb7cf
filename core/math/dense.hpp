// Small dense systems of equations.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace neve {

// Solve A x = b for a row-major n x n matrix by Gaussian elimination with row pivots; x replaces b. A column without a
// pivot leaves its unknown at zero.
inline void solve(std::vector<double>& A, std::vector<double>& b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t best = k;
    for (std::size_t r = k + 1; r < n; ++r) {
      if (std::abs(A[r * n + k]) > std::abs(A[best * n + k])) best = r;
    }
    if (A[best * n + k] == 0) continue;
    for (std::size_t c = 0; best != k && c < n; ++c) std::swap(A[best * n + c], A[k * n + c]);
    std::swap(b[best], b[k]);
    for (std::size_t r = k + 1; r < n; ++r) {
      const double f = A[r * n + k] / A[k * n + k];
      if (f == 0) continue;
      for (std::size_t c = k; c < n; ++c) A[r * n + c] -= f * A[k * n + c];
      b[r] -= f * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t c = k + 1; c < n; ++c) b[k] -= A[k * n + c] * b[c];
    b[k] = A[k * n + k] == 0 ? 0 : b[k] / A[k * n + k];
  }
}

}  // namespace neve
