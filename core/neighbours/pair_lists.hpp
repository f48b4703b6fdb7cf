// Neighbour lists (Verlet 1967): of each particle those within reach, and what is remembered of each pair.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "math/pack.hpp"

namespace neve {

// Rows that are stepped together: a pack.
template <class T>
inline constexpr std::size_t group_rows = std::size_t(lane_count<T>);

// What is remembered of the pairs of each row, seen from it: entries [begin[p], begin[p + 1]).
template <class T>
struct PairMemory {
  std::vector<std::uint32_t> begin{0};
  std::vector<std::int32_t> row;
  std::vector<std::array<T, 4>> values;  // hold, and the three numbers of its vector
};

// A pair that the list of `row` gains or loses.
struct PairChange {
  std::int32_t row, other;
  bool joins;
  bool operator<(const PairChange& o) const { return row != o.row ? row < o.row : other < o.other; }
};

// The entries of a group of rows lie slot by slot, the lanes of a slot together: so a group is stepped without sums over lanes.
// Each pair has two entries, one seen from each side. Those of a row are sorted by the other's row, and what does not
// touch adds nothing: so forces depend on rows and memory, not on when a pair was listed. Lanes without an entry name a
// row that is near nothing, number `rows`.
template <class T>
struct Neighbours {
  static constexpr std::uint32_t none = ~std::uint32_t(0);
  static constexpr std::uint32_t lanes = std::uint32_t(group_rows<T>);
  static constexpr std::uint32_t spare = 2;    // slots of a group beyond those that it needs
  static constexpr std::uint32_t most = 4096;  // entries of a row: snow has some thirty
  std::vector<std::int32_t> row;
  std::vector<T> hold, a, b, c;
  std::vector<std::uint32_t> base;         // of each group: its first entry
  std::vector<std::uint16_t> room, slots;  // of each group: slots that are its own, and those in use
  std::vector<std::uint16_t> filled;       // of each row: its entries
  std::size_t rows = 0, wasted = 0;        // entries that no group owns any more

  std::size_t size() const { return row.size(); }
  std::size_t groups() const { return base.size(); }
  std::uint32_t first(std::size_t p) const { return base[p / lanes] + std::uint32_t(p % lanes); }
  // Call f(e) for each entry of row p.
  template <class F>
  void each(std::size_t p, F&& f) const {
    std::uint32_t e = first(p);
    for (std::uint32_t n = filled[p]; n > 0; --n, e += lanes) f(e);
  }
  // The entry of row p for row q, or none.
  std::uint32_t find(std::size_t p, std::int32_t q) const {
    std::uint32_t found = none;
    each(p, [&](std::uint32_t e) { found = row[e] == q ? e : found; });
    return found;
  }
  void copy_memory(std::uint32_t from, std::uint32_t to) {
    hold[to] = hold[from], a[to] = a[from], b[to] = b[from], c[to] = c[from];
  }
  std::size_t bytes() const {
    return row.size() * (sizeof(std::int32_t) + 4 * sizeof(T)) + base.size() * 8 + filled.size() * 2;
  }

  // Have n rows without entries; each group has `spare` slots more than wanted(g).
  template <class F>
  void clear(std::size_t n, F&& wanted) {
    rows = n, wasted = 0;
    const std::size_t count = (n + lanes - 1) / lanes;
    base.resize(count), room.resize(count), slots.assign(count, 0), filled.assign(count * lanes, 0);
    std::uint32_t at = 0;
    for (std::size_t g = 0; g < count; ++g) {
      base[g] = at, room[g] = std::uint16_t(wanted(g) + spare);
      at += room[g] * lanes;
    }
    row.assign(at, std::int32_t(n)), hold.assign(at, T(0));
    a.resize(at), b.resize(at), c.resize(at);
  }
  // Make room for `most` slots in group g.
  void make_room(std::size_t g, std::size_t most) {
    if (most <= room[g]) return;
    const std::uint32_t from = base[g], to = std::uint32_t(row.size()), held = room[g] * lanes;
    wasted += held;
    room[g] = std::uint16_t(most + spare), base[g] = to;
    const std::size_t end = to + room[g] * lanes;
    row.resize(end, std::int32_t(rows)), hold.resize(end, T(0));
    a.resize(end), b.resize(end), c.resize(end);
    std::copy_n(row.begin() + from, held, row.begin() + to);
    std::copy_n(hold.begin() + from, held, hold.begin() + to);
    for (auto* of : {&a, &b, &c}) std::copy_n(of->begin() + from, held, of->begin() + to);
  }
  // Give row p the entries `fresh`, sorted; what is remembered of pairs stays. Rows of other groups may be written meanwhile.
  void write(std::size_t p, const std::int32_t* fresh, std::size_t count, PairMemory<T>& spare_memory) {
    auto& kept = spare_memory;
    kept.row.clear(), kept.values.clear();
    const std::uint32_t e0 = first(p);
    each(p, [&](std::uint32_t e) {
      if (hold[e] == T(0)) return;
      kept.row.push_back(row[e]), kept.values.push_back({hold[e], a[e], b[e], c[e]});
    });
    std::size_t k = 0;
    std::uint32_t e = e0;
    for (std::size_t n = 0; n < count; ++n, e += lanes) {
      row[e] = fresh[n];
      while (k < kept.row.size() && kept.row[k] < fresh[n]) ++k;
      if (k < kept.row.size() && kept.row[k] == fresh[n]) {
        hold[e] = kept.values[k][0], a[e] = kept.values[k][1], b[e] = kept.values[k][2],
        c[e] = kept.values[k][3];
      } else {
        hold[e] = a[e] = b[e] = c[e] = T(0);
      }
    }
    for (std::size_t n = count; n < filled[p]; ++n, e += lanes) row[e] = std::int32_t(rows), hold[e] = T(0);
    filled[p] = std::uint16_t(count);
  }
  // Let pairs join and leave the list of row p, by `changes`, sorted; those of which something is remembered stay. There must be room.
  void edit(std::size_t p, const PairChange* changes, const PairChange* end, PairMemory<T>& spare_memory) {
    auto& now = spare_memory;
    now.row.clear(), now.values.clear();
    const auto join = [&](std::int32_t q) { now.row.push_back(q), now.values.push_back({}); };
    each(p, [&](std::uint32_t e) {
      while (changes != end && changes->other < row[e]) {
        if (changes->joins) join(changes->other);
        ++changes;
      }
      const bool named = changes != end && changes->other == row[e];
      if (!named || changes->joins || hold[e] != T(0))
        now.row.push_back(row[e]), now.values.push_back({hold[e], a[e], b[e], c[e]});
      changes += named;
    });
    for (; changes != end; ++changes) {
      if (changes->joins) join(changes->other);
    }
    std::uint32_t e = first(p);
    for (std::size_t n = 0; n < now.row.size(); ++n, e += lanes) {
      row[e] = now.row[n];
      hold[e] = now.values[n][0], a[e] = now.values[n][1], b[e] = now.values[n][2], c[e] = now.values[n][3];
    }
    for (std::size_t n = now.row.size(); n < filled[p]; ++n, e += lanes)
      row[e] = std::int32_t(rows), hold[e] = T(0);
    filled[p] = std::uint16_t(now.row.size());
  }
  // See how many slots group g has in use.
  void count_slots(std::size_t g) {
    slots[g] = *std::max_element(filled.begin() + std::ptrdiff_t(g * lanes),
                                 filled.begin() + std::ptrdiff_t((g + 1) * lanes));
  }
};

// All that is remembered of pairs.
template <class T>
PairMemory<T> memory_of(const Neighbours<T>& lists) {
  PairMemory<T> out;
  for (std::size_t p = 0; p < lists.rows; ++p) {
    lists.each(p, [&](std::uint32_t e) {
      if (lists.hold[e] == T(0)) return;
      out.row.push_back(lists.row[e]);
      out.values.push_back({lists.hold[e], lists.a[e], lists.b[e], lists.c[e]});
    });
    out.begin.push_back(std::uint32_t(out.row.size()));
  }
  return out;
}

}  // namespace neve
