// An order of rows in which points that are near each other lie near each other in memory.
#pragma once

#include <limits>

#include "neighbours/search.hpp"

namespace neve {

namespace detail {

// The lowest 21 bits of a, two free bits between each.
inline std::uint64_t spread_bits(std::uint64_t a) {
  a &= 0x1fffff;
  a = (a | a << 32) & 0x1f00000000ffffull;
  a = (a | a << 16) & 0x1f0000ff0000ffull;
  a = (a | a << 8) & 0x100f00f00f00f00full;
  a = (a | a << 4) & 0x10c30c30c30c30c3ull;
  return (a | a << 2) & 0x1249249249249249ull;
}

}  // namespace detail

// Return the order that sorts points along a curve through cells of edge h [m] (Morton 1966), those for which first(p) holds
// before the others: order[i] becomes the row of the i-th. Throws std::domain_error with the birth number of a point
// that is not finite or more than 2^20 cells from the lowest.
template <class S, class F>
std::vector<std::uint32_t> order_along_curve(const S& s, double h, F&& first) {
  using T = number_of<S>;
  std::array<double, 3> low{};
  for (int k = 0; k < 3; ++k) {
    T least = std::numeric_limits<T>::max();  // of what is finite
    for (std::size_t p = 0; p < s.count; ++p) least = std::min(least, s.x.column(k)[p]);
    low[std::size_t(k)] = double(least);
  }
  std::vector<std::uint64_t> keys(s.count);
  std::vector<std::uint32_t> order(s.count), other(s.count);
  std::uint64_t all = 0;
  for (std::size_t p = 0; p < s.count; ++p) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
      const double u = std::floor((double(s.x.column(k)[p]) - low[std::size_t(k)]) / h);
      if (!(u >= 0 && u < (1 << 20))) throw std::domain_error(std::to_string(s.id[p]));
      key |= detail::spread_bits(std::uint64_t(u)) << k;
    }
    keys[p] = key, order[p] = std::uint32_t(p), all |= key;
  }
  int bits = 1;
  while (bits < 63 && all >> bits) ++bits;
  for (std::size_t p = 0; p < s.count; ++p) keys[p] |= std::uint64_t(!first(p)) << bits;
  const int passes = (bits + 1 + 10) / 11, digit = (bits + passes) / passes;
  for (int pass = 0; pass < passes; ++pass) {
    detail::radix_pass(keys, order, other, pass * digit, digit);
    order.swap(other);
  }
  return order;
}

}  // namespace neve
