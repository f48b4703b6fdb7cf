// Which particle has lost its numbers.
#pragma once

#include "mpm/state.hpp"

namespace neve {

// The row of the first particle (by birth number) with a value that is not finite, or -1.
template <class T>
std::int64_t first_not_finite(const State<T>& state) {
  std::int64_t found = -1;
  for (std::size_t p = 0; p < state.count; ++p) {
    T sum = state.J_P.column(0)[p];
    for (int k = 0; k < 3; ++k) sum += state.x.column(k)[p] + state.v.column(k)[p];
    for (int k = 0; k < 9; ++k) sum += state.F_E.column(k)[p] + state.C.column(k)[p];
    for (int k = 0; k < 6; ++k) sum += state.tau.column(k)[p];
    for (int k = 0; k < state.modes.components(); ++k) sum += state.modes.column(k)[p];
    const bool earlier = found < 0 || state.id[p] < state.id[static_cast<std::size_t>(found)];
    if (sum - sum != T(0) && earlier) found = static_cast<std::int64_t>(p);
  }
  return found;
}

}  // namespace neve
