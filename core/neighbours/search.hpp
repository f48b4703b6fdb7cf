// Which points lie within reach of which, by cells, for points that are sorted by cell; and how to sort them.
#pragma once

#include <bit>

#include "math/mat3.hpp"
#include "neighbours/cells.hpp"

namespace neve {

namespace detail {

// Rows that were found, with room for candidates and the squares of their distances.
struct FoundRows {
  std::vector<std::int32_t> rows;
  std::size_t count = 0;

  // Where the next rows go, with room for `most` and a pack.
  std::int32_t* room(std::size_t most) {
    constexpr std::size_t pack = 16;
    if (count + most + pack > rows.size()) rows.resize(2 * (count + most + pack));
    return rows.data() + count;
  }
};

// Write the rows among [low, low + most) within the root of reach2 of `at`, but row `self`, to `out`; return how many.
// Columns may be read a pack past their end, and `out` be written one.
template <class T>
std::size_t rows_within(const T* x, const T* y, const T* z, std::uint32_t low, std::uint32_t most,
                        const Vec3<T>& at, std::uint32_t self, T reach2, std::int32_t* out) {
  std::size_t n = 0;
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<T, float>) {
    const __m512 cx = _mm512_set1_ps(at.x), cy = _mm512_set1_ps(at.y), cz = _mm512_set1_ps(at.z);
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (std::uint32_t k = 0; k < most; k += 16) {
      const __m512 dx = _mm512_sub_ps(_mm512_loadu_ps(x + low + k), cx);
      const __m512 dy = _mm512_sub_ps(_mm512_loadu_ps(y + low + k), cy);
      const __m512 dz = _mm512_sub_ps(_mm512_loadu_ps(z + low + k), cz);
      const __m512 d2 = _mm512_fmadd_ps(dz, dz, _mm512_fmadd_ps(dy, dy, _mm512_mul_ps(dx, dx)));
      const __m512i rows = _mm512_add_epi32(_mm512_set1_epi32(std::int32_t(low + k)), lane);
      const auto some = most - k < 16 ? __mmask16((1u << (most - k)) - 1) : __mmask16(0xffff);
      const auto hits = __mmask16(_mm512_mask_cmp_ps_mask(some, d2, _mm512_set1_ps(reach2), _CMP_LE_OQ) &
                                  _mm512_cmpneq_epi32_mask(rows, _mm512_set1_epi32(std::int32_t(self))));
      _mm512_storeu_si512(out + n, _mm512_maskz_compress_epi32(hits, rows));
      n += std::size_t(std::popcount(std::uint32_t(hits)));
    }
    return n;
  }
#endif
  for (std::uint32_t q = low; q < low + most; ++q) {
    const T dx = x[q] - at.x, dy = y[q] - at.y, dz = z[q] - at.z;
    out[n] = std::int32_t(q);
    n += (dx * dx + dy * dy + dz * dz <= reach2) & (q != self);
  }
  return n;
}

// Append the rows within reach of a point, of those in the rows of cells around the cell of number `key`, to `found`.
// `first` holds, for each of nine rows of cells, the first cell that may be of interest, and only grows from cell to cell.
class NeighbourSearch {
 public:
  NeighbourSearch(const Cells& cells, std::uint64_t key) : cells_(cells) {
    for (int r = 0; r < 9; ++r) {
      const auto at = std::lower_bound(cells.key.begin(), cells.key.end(), from(key, r));
      first_[std::size_t(r)] = std::size_t(at - cells.key.begin());
    }
  }
  void move_to(std::uint64_t key) {
    for (int r = 0; r < 9; ++r) {
      const std::uint64_t low = from(key, r), high = low + 2;
      std::size_t& f = first_[std::size_t(r)];
      while (f < cells_.key.size() && cells_.key[f] < low) ++f;
      std::size_t last = f;
      while (last < cells_.key.size() && cells_.key[last] <= high) ++last;
      low_[std::size_t(r)] = cells_.begin[f];
      high_[std::size_t(r)] = cells_.begin[last];
    }
  }
  template <class S, class T>
  void append(const S& s, const Vec3<T>& at, std::uint32_t self, T reach2, FoundRows& found) const {
    const T *x = s.x.column(0), *y = s.x.column(1), *z = s.x.column(2);
    for (std::size_t r = 0; r < 9; ++r) {
      const std::uint32_t low = low_[r], most = high_[r] - low;
      found.count += rows_within(x, y, z, low, most, at, self, reach2, found.room(most));
    }
  }

 private:
  std::uint64_t from(std::uint64_t key, int r) const {
    const std::int64_t dy = r % 3 - 1, dz = r / 3 - 1;
    return key - 1 + std::uint64_t(dy * (std::int64_t(1) << cells_.shift_y)) +
           std::uint64_t(dz * (std::int64_t(1) << cells_.shift_z));
  }
  const Cells& cells_;
  std::array<std::size_t, 9> first_{};
  std::array<std::uint32_t, 9> low_{}, high_{};
};

}  // namespace detail

// For each point of `a`, the rows of the points of `b` within the root of reach2, but itself if both are one set: those of
// row p are [begin[p], begin[p + 1]) of what room(n) returns, where n entries have to fit. Both are sorted by cells with
// the same bounds, `of_a` and `of_b`.
template <class A, class B, class T, class Room>
void find_rows(const A& a, const Cells& of_a, const B& b, const Cells& of_b, T reach2,
               std::vector<detail::FoundRows>& found, std::vector<std::uint32_t>& begin, Room&& room) {
  const bool same = static_cast<const void*>(&a) == static_cast<const void*>(&b);
  found.resize(static_cast<std::size_t>(thread_count()));
  begin.assign(a.count + 1, 0);
  each_chunk(of_a.key.size(), [&](int chunk, std::size_t first, std::size_t last) {
    if (first == last) return;
    auto& mine = found[std::size_t(chunk)];
    mine.count = 0;
    detail::NeighbourSearch search(of_b, of_a.key[first]);
    for (std::size_t c = first; c < last; ++c) {
      search.move_to(of_a.key[c]);
      for (std::uint32_t p = of_a.begin[c]; p < of_a.begin[c + 1]; ++p) {
        const std::size_t before = mine.count;
        const Vec3<T> at{a.x.column(0)[p], a.x.column(1)[p], a.x.column(2)[p]};
        search.append(b, at, same ? p : ~std::uint32_t(0), reach2, mine);
        begin[p + 1] = std::uint32_t(mine.count - before);
      }
    }
  });
  for (std::size_t p = 0; p < a.count; ++p) begin[p + 1] += begin[p];
  std::int32_t* row = room(std::size_t(begin.back()));
  each_chunk(of_a.key.size(), [&](int chunk, std::size_t first, std::size_t last) {
    const auto& mine = found[std::size_t(chunk)];
    if (first < last) std::copy_n(mine.rows.begin(), mine.count, row + begin[of_a.begin[first]]);
  });
}

// Move every column into the new order: addresses stay valid.
// (`each_column` of the set calls a function with each.)
template <class S>
void reorder(S& s, const std::vector<std::uint32_t>& order) {
  std::vector<double> spare(s.count);  // wide enough for every column
  s.each_column([&](auto* column) {
    auto* to = reinterpret_cast<decltype(column)>(spare.data());
    each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) to[p] = column[order[p]];
    });
    each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
      std::copy(to + begin, to + end, column + begin);
    });
  });
}

}  // namespace neve
