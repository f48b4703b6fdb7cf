// Neighbour lists (Verlet 1967): of each particle those within reach, and what is remembered of each pair.
#pragma once

#include <bit>

#include "particles/cells.hpp"
#include "particles/contact.hpp"

namespace neve {

// The entries of particle p are [begin[p], begin[p + 1]), by rows; each pair has two entries, one seen from each side.
// Arrays may be read one pack past their ends.
template <class T>
struct Neighbours {
  std::vector<std::int32_t> row;
  std::vector<T> hold, a, b, c;  // Memory: hold, and the three numbers of its vector
  std::vector<std::uint32_t> begin{0};
  Field<T, 3> start;           // where the particles were when the lists were made [m]
  double reach = 0, skin = 0;  // distance of pairs in the lists, and of it what is spare [m]
  Vec3<double> drift{};        // velocity that all are expected to share [m/s]
  double elapsed = 0;          // since the lists were made [s]

  std::size_t size() const { return begin.back(); }
  // Make room for n entries without memory. What is left of a row beyond them is a row that exists.
  void resize(std::size_t n) {
    constexpr std::size_t spare = 64;
    if (row.size() < n + spare) {
      const std::size_t room = n + n / 8 + spare;
      row.resize(room, 0);
      for (auto* values : {&hold, &a, &b, &c}) values->resize(room);
    }
    std::fill_n(row.begin() + std::ptrdiff_t(n), spare, 0);
  }
  std::size_t bytes() const { return row.size() * (sizeof(std::int32_t) + 4 * sizeof(T)) + start.bytes(); }
};

namespace detail {

// Rows that were found, with room for candidates and the squares of their distances.
template <class T>
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

// Write the rows among [low, low + most) within the root of reach2 of row p, but p, to `out`; return how many. Columns may be
// read a pack past their end, and `out` be written one.
template <class T>
std::size_t rows_within(const T* x, const T* y, const T* z, std::uint32_t low, std::uint32_t most,
                        std::uint32_t p, T reach2, std::int32_t* out) {
  const T px = x[p], py = y[p], pz = z[p];
  std::size_t n = 0;
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<T, float>) {
    const __m512 cx = _mm512_set1_ps(px), cy = _mm512_set1_ps(py), cz = _mm512_set1_ps(pz);
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (std::uint32_t k = 0; k < most; k += 16) {
      const __m512 dx = _mm512_sub_ps(_mm512_loadu_ps(x + low + k), cx);
      const __m512 dy = _mm512_sub_ps(_mm512_loadu_ps(y + low + k), cy);
      const __m512 dz = _mm512_sub_ps(_mm512_loadu_ps(z + low + k), cz);
      const __m512 d2 = _mm512_fmadd_ps(dz, dz, _mm512_fmadd_ps(dy, dy, _mm512_mul_ps(dx, dx)));
      const __m512i rows = _mm512_add_epi32(_mm512_set1_epi32(std::int32_t(low + k)), lane);
      const auto some = most - k < 16 ? __mmask16((1u << (most - k)) - 1) : __mmask16(0xffff);
      const auto hits = __mmask16(_mm512_mask_cmp_ps_mask(some, d2, _mm512_set1_ps(reach2), _CMP_LE_OQ) &
                                  _mm512_cmpneq_epi32_mask(rows, _mm512_set1_epi32(std::int32_t(p))));
      _mm512_storeu_si512(out + n, _mm512_maskz_compress_epi32(hits, rows));
      n += std::size_t(std::popcount(std::uint32_t(hits)));
    }
    return n;
  }
#endif
  for (std::uint32_t q = low; q < low + most; ++q) {
    const T dx = x[q] - px, dy = y[q] - py, dz = z[q] - pz;
    out[n] = std::int32_t(q);
    n += (dx * dx + dy * dy + dz * dz <= reach2) & (q != p);
  }
  return n;
}

// Where `row` stands among `count` rows, or count.
inline std::uint32_t place_of(const std::int32_t* rows, std::uint32_t count, std::int32_t row) {
  std::uint32_t at = 0, found = 0;
  for (std::uint32_t n = 0; n < count; ++n) {
    const std::uint32_t here = rows[n] == row;
    at += here * n, found += here;
  }
  return found ? at : count;
}

// Append the rows within reach of particle p, of those in the rows of cells around cell number c, to `found`. `first`
// holds, for each of nine rows of cells, the first cell that may be of interest, and only grows from cell to cell.
class NeighbourSearch {
 public:
  NeighbourSearch(const Cells& cells, std::size_t c) : cells_(cells) {
    const std::uint64_t key = cells.key[c];
    for (int r = 0; r < 9; ++r) {
      const auto at = std::lower_bound(cells.key.begin(), cells.key.end(), from(key, r));
      first_[std::size_t(r)] = std::size_t(at - cells.key.begin());
    }
  }
  void move_to(std::size_t c) {
    const std::uint64_t key = cells_.key[c];
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
  template <class T>
  void append(const ParticleState<T>& s, std::uint32_t p, T reach2, FoundRows<T>& found) const {
    const T *x = s.x.column(0), *y = s.x.column(1), *z = s.x.column(2);
    for (std::size_t r = 0; r < 9; ++r) {
      const std::uint32_t low = low_[r], most = high_[r] - low;
      found.count += rows_within(x, y, z, low, most, p, reach2, found.room(most));
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

// The rows within reach of each particle, into lists without memory.
template <class T>
void find_neighbours(const ParticleState<T>& s, const Cells& cells, Neighbours<T>& lists,
                     std::vector<FoundRows<T>>& found) {
  const T reach2 = T(lists.reach * lists.reach);
  found.resize(static_cast<std::size_t>(thread_count()));
  lists.begin.assign(s.count + 1, 0);
  each_chunk(cells.key.size(), [&](int chunk, std::size_t begin, std::size_t end) {
    if (begin == end) return;
    auto& mine = found[std::size_t(chunk)];
    mine.count = 0;
    NeighbourSearch search(cells, begin);
    for (std::size_t c = begin; c < end; ++c) {
      search.move_to(c);
      for (std::uint32_t p = cells.begin[c]; p < cells.begin[c + 1]; ++p) {
        const std::size_t before = mine.count;
        search.append(s, p, reach2, mine);
        lists.begin[p + 1] = std::uint32_t(mine.count - before);
      }
    }
  });
  for (std::size_t p = 0; p < s.count; ++p) lists.begin[p + 1] += lists.begin[p];
  lists.resize(lists.size());
  each_chunk(cells.key.size(), [&](int chunk, std::size_t begin, std::size_t end) {
    const auto& mine = found[std::size_t(chunk)];
    if (begin < end)
      std::copy_n(mine.rows.begin(), mine.count, lists.row.begin() + lists.begin[cells.begin[begin]]);
  });
}

// Give the new lists what the old ones remember. order[new row] is an old row.
template <class T>
void carry_over(const Neighbours<T>& old, const std::vector<std::uint32_t>& order, Neighbours<T>& lists) {
  std::vector<std::int32_t> row_now(order.size());
  each_chunk(order.size(), [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) row_now[order[p]] = std::int32_t(p);
  });
  each_chunk(order.size(), [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const std::uint32_t first = lists.begin[p], last = lists.begin[p + 1];
      std::fill(lists.hold.begin() + first, lists.hold.begin() + last, T(0));
      if (order[p] + 1 >= old.begin.size()) continue;  // born since
      for (std::uint32_t e = old.begin[order[p]]; e < old.begin[order[p] + 1]; ++e) {
        if (old.hold[e] == T(0)) continue;
        const std::int32_t other = row_now[std::size_t(old.row[e])];
        const std::uint32_t n = first + place_of(lists.row.data() + first, last - first, other);
        if (n == last) continue;
        lists.hold[n] = old.hold[e], lists.a[n] = old.a[e], lists.b[n] = old.b[e], lists.c[n] = old.c[e];
      }
    }
  });
}

// Move every column into the new order: addresses stay valid.
template <class T>
void reorder(ParticleState<T>& s, const std::vector<std::uint32_t>& order) {
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

}  // namespace detail

// How all particles move: their mean velocity, and the largest speed against it, over all particles in a fixed order.
struct Motion {
  Vec3<double> drift{};  // [m/s]
  double speed = 0;      // [m/s]
};

template <class T>
Motion motion_of(const ParticleState<T>& s) {
  Motion out;
  double most = 0;
  for (int k = 0; k < 3; ++k) {
    double sum = 0;
    for (std::size_t p = 0; p < s.count; ++p) sum += double(s.v.column(k)[p]);
    out.drift[k] = s.count ? sum / double(s.count) : 0.0;
  }
  for (std::size_t p = 0; p < s.count; ++p) {
    double v2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double v = double(s.v.column(k)[p]) - out.drift[k];
      v2 += v * v;
    }
    most = std::max(most, v2);
  }
  out.speed = std::sqrt(most);
  return out;
}

// Memory that is used again from one time to the next.
template <class T>
struct RebuildRoom {
  Neighbours<T> lists;
  std::vector<std::uint32_t> order;
  std::vector<detail::FoundRows<T>> found;
};

// Sort the particles by cell and make the lists of all pairs within `near` [m] and some spare, the more the faster they
// move: enough for eight steps of dt [s], but a quarter of `near` at most. As long as no particle has moved by half of the
// spare against the drift, no other pair can touch. What is remembered of pairs stays.
template <class T>
void rebuild(ParticleState<T>& s, Neighbours<T>& lists, RebuildRoom<T>& room, double near, double dt) {
  const Motion motion = motion_of(s);
  const double spare = std::clamp(2 * 8 * motion.speed * dt, 0.06 * near, 0.25 * near);
  Neighbours<T>& fresh = room.lists;
  fresh.reach = near + spare, fresh.skin = spare, fresh.drift = motion.drift, fresh.elapsed = 0;
  const Cells cells = cells_of(s, fresh.reach, room.order);
  detail::reorder(s, room.order);
  detail::find_neighbours(s, cells, fresh, room.found);
  detail::carry_over(lists, room.order, fresh);
  fresh.start.resize(s.count);
  for (int k = 0; k < 3; ++k) std::copy_n(s.x.column(k), s.count, fresh.start.column(k));
  std::swap(lists, fresh);
}

// Bond all pairs of particles of one source whose birth numbers are `first` or more and whose gap is at most `gap` of their
// radii: at rest as they lie. A bond of particles that overlap does not break before they part: none presses then.
template <class T>
void make_bonds(const ParticleState<T>& s, Neighbours<T>& lists, std::uint32_t first, T gap) {
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      for (std::uint32_t e = lists.begin[p]; e < lists.begin[p + 1]; ++e) {
        const auto q = std::size_t(lists.row[e]);
        if (s.id[p] < first || s.id[q] < first || s.source[p] != s.source[q]) continue;
        const T *r = s.radius.column(0), *limit = s.bond.column(0);
        T d2 = 0;
        for (int k = 0; k < 3; ++k) {
          const T d = s.x.column(k)[p] - s.x.column(k)[q];
          d2 += d * d;
        }
        const T radii = r[p] + r[q], overlap = radii - std::sqrt(d2);
        const T hold = T(0.5) * (limit[p] + limit[q]) * radii;
        if (overlap < -gap * radii || !(hold > T(0))) continue;
        lists.hold[e] = std::max(hold, overlap), lists.a[e] = overlap, lists.b[e] = lists.c[e] = T(0);
      }
    }
  });
}

}  // namespace neve
