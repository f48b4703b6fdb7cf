// Sort points by cell: a stable radix sort of cell numbers, in parallel.
//
// A set of points S has `count`, `x`, a Field of three columns [m], and birth numbers `id`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "mpm/state.hpp"
#include "threads.hpp"

namespace neve {

// Cells that hold points, in rising order of their numbers: x fastest, so that rows of cells are runs of points.
struct Cells {
  std::vector<std::uint64_t> key;    // number of each cell
  std::vector<std::uint32_t> begin;  // its first point; one more at the end
  int shift_y = 0, shift_z = 0;      // bits below those of y, and of z
};

// The cells that points lie in, along each axis.
struct CellBounds {
  std::array<std::int32_t, 3> low{1 << 30, 1 << 30, 1 << 30}, high{-(1 << 30), -(1 << 30), -(1 << 30)};
  std::int64_t lost = -1;  // birth number of the first point beyond the limit
  void merge(const CellBounds& o) {
    for (std::size_t k = 0; k < 3; ++k)
      low[k] = std::min(low[k], o.low[k]), high[k] = std::max(high[k], o.high[k]);
    if (o.lost >= 0 && (lost < 0 || o.lost < lost)) lost = o.lost;
  }
};

// The numbers of a point in a set.
template <class S>
using number_of = std::remove_cvref_t<decltype(std::declval<const S&>().x.column(0)[0])>;

namespace detail {

inline constexpr double cell_limit = 1 << 19;  // cells from the origin, each way

inline int bits_for(std::int32_t cells) {
  int bits = 1;
  while ((std::int64_t(1) << bits) < cells) ++bits;
  return bits;
}

// One pass of the sort: by `digit` bits from bit `first` on.
inline void radix_pass(const std::vector<std::uint64_t>& keys, const std::vector<std::uint32_t>& from,
                       std::vector<std::uint32_t>& to, int first, int digit) {
  const std::size_t buckets = std::size_t(1) << digit, n = from.size();
  const auto chunks = static_cast<std::size_t>(thread_count());
  std::vector<std::uint32_t> next(chunks * buckets, 0);
  const auto bucket = [&](std::uint32_t p) { return (keys[p] >> first) & (buckets - 1); };
  each_chunk(n, [&](int c, std::size_t begin, std::size_t end) {
    std::uint32_t* count = next.data() + std::size_t(c) * buckets;
    for (std::size_t i = begin; i < end; ++i) ++count[bucket(from[i])];
  });
  std::uint32_t at = 0;
  for (std::size_t b = 0; b < buckets; ++b) {
    for (std::size_t c = 0; c < chunks; ++c) {
      const std::uint32_t here = next[c * buckets + b];
      next[c * buckets + b] = at;
      at += here;
    }
  }
  each_chunk(n, [&](int c, std::size_t begin, std::size_t end) {
    std::uint32_t* slot = next.data() + std::size_t(c) * buckets;
    for (std::size_t i = begin; i < end; ++i) to[slot[bucket(from[i])]++] = from[i];
  });
}

}  // namespace detail

// Return the bounds of the cells of edge h [m] that hold points, and which cell each lies in. Throws std::domain_error for
// a point that is not finite or too far away.
template <class S>
CellBounds cell_bounds(const S& s, double h, std::vector<std::array<std::int32_t, 3>>& at) {
  using T = number_of<S>;
  const T inv = T(1 / h);
  std::vector<CellBounds> parts(static_cast<std::size_t>(thread_count()));
  at.resize(s.count);
  each_chunk(s.count, [&](int c, std::size_t begin, std::size_t end) {
    CellBounds& mine = parts[std::size_t(c)];
    for (std::size_t p = begin; p < end; ++p) {
      for (std::size_t k = 0; k < 3; ++k) {
        const T u = std::floor(s.x.column(int(k))[p] * inv);
        if (!(std::abs(u) < T(detail::cell_limit))) {
          if (mine.lost < 0 || s.id[p] < mine.lost) mine.lost = s.id[p];
          at[p][k] = 0;
          continue;
        }
        at[p][k] = static_cast<std::int32_t>(u);
        mine.low[k] = std::min(mine.low[k], at[p][k]), mine.high[k] = std::max(mine.high[k], at[p][k]);
      }
    }
  });
  CellBounds bounds;
  for (const auto& part : parts) bounds.merge(part);
  if (bounds.lost >= 0) throw std::domain_error(std::to_string(bounds.lost));
  return bounds;
}

// Return the cells that hold the points which lie in the cells `at`, within `bounds`; order[i] becomes the row of the i-th
// point by cell, and by row within one. Cells of different sets with the same bounds have the same numbers.
inline Cells sorted_cells(const std::vector<std::array<std::int32_t, 3>>& at, const CellBounds& bounds,
                          std::vector<std::uint32_t>& order) {
  const std::size_t count = at.size();
  int bits[3];
  for (std::size_t k = 0; k < 3; ++k)
    bits[k] = bounds.high[k] >= bounds.low[k] ? detail::bits_for(bounds.high[k] - bounds.low[k] + 3) : 1;
  Cells cells;
  cells.shift_y = bits[0], cells.shift_z = bits[0] + bits[1];
  std::vector<std::uint64_t> keys(count);
  order.resize(count);
  each_chunk(count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const auto offset = [&](std::size_t k) { return std::uint64_t(at[p][k] - bounds.low[k] + 1); };
      keys[p] = offset(0) | offset(1) << cells.shift_y | offset(2) << cells.shift_z;
      order[p] = std::uint32_t(p);
    }
  });
  const int all = bits[0] + bits[1] + bits[2], passes = (all + 10) / 11, digit = (all + passes - 1) / passes;
  std::vector<std::uint32_t> other(count);
  for (int pass = 0; pass < passes; ++pass) {
    detail::radix_pass(keys, order, other, pass * digit, digit);
    order.swap(other);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 0 || keys[order[i]] != cells.key.back()) {
      cells.key.push_back(keys[order[i]]);
      cells.begin.push_back(std::uint32_t(i));
    }
  }
  cells.begin.push_back(std::uint32_t(count));
  return cells;
}

// Return the cells of edge h [m] that hold points; order[i] becomes the row of the i-th point by cell, and by row within
// one. Throws std::domain_error for a point that is not finite or too far away.
template <class S>
Cells cells_of(const S& s, double h, std::vector<std::uint32_t>& order) {
  std::vector<std::array<std::int32_t, 3>> at;
  const CellBounds bounds = cell_bounds(s, h, at);
  return sorted_cells(at, bounds, order);
}

}  // namespace neve
