// When pairs are listed, and for how long lists hold.
#pragma once

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "neighbours/order.hpp"
#include "neighbours/pair_lists.hpp"
#include "neighbours/start_grid.hpp"
#include "particles/contact.hpp"
#include "particles/state.hpp"

namespace neve {

// The lists of all pairs that may touch before they are looked at again, and where particles were when they were listed.
//
// Particle p may move by way_p from its start, against the drift that all share. Listed are the pairs whose starts are within
// near + way_p + way_q, so no other pair comes within `near`, and those of which something is remembered: a bond that cannot
// break holds at any distance. A particle that has moved farther gets a new start, and only
// its own lists, and those that it joins or leaves, change.
template <class T>
struct Listing {
  static constexpr double least_way = 0.04, most_way = 0.125;  // of `near`
  static constexpr double steps = 6;                           // that a way should last
  Neighbours<T> lists;
  StartGrid<T> grid;
  double near = 0, dt = 0;  // distance of pairs that may act on each other [m]; a step [s]
  Vec3<double> drift{};     // velocity that all are expected to share [m/s]
  double elapsed = 0;       // since the drift counts [s]

  bool made_for(std::size_t count) const { return near > 0 && lists.rows == count; }
  std::size_t bytes() const { return lists.bytes() + grid.bytes(); }
  // How far the drift has taken all [m].
  Vec3<T> shift() const { return {T(drift.x * elapsed), T(drift.y * elapsed), T(drift.z * elapsed)}; }

  // What a start of particle p is now.
  Quartet<T> start_now(const ParticleState<T>& s, std::size_t p) const {
    const Vec3<T> shifted = shift();
    double v2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double v = double(s.v.column(k)[p]) - drift[k];
      v2 += v * v;
    }
    const double way = std::clamp(steps * std::sqrt(v2) * dt, least_way * near, most_way * near);
    return {s.x.column(0)[p] - shifted.x, s.x.column(1)[p] - shifted.y, s.x.column(2)[p] - shifted.z,
            std::isfinite(way) ? T(way) : T(most_way * near)};
  }

  // Rows that were found: those of rows[i] are `count[i]` from `from[i]` on in found[thread[i]].
  struct Found {
    std::vector<std::int32_t> rows;
    std::vector<std::uint32_t> from, count;
    std::vector<int> thread;
    std::vector<detail::FoundRows> by_thread;
    const std::int32_t* of(std::size_t i) const {
      return by_thread[std::size_t(thread[i])].rows.data() + from[i];
    }
  };
  Found found;  // memory that is used again
  std::vector<PairChange> changes;
  std::vector<char> moves;

  // Find the neighbours of the rows in f, and those of which something is remembered: each_kept(p, g) calls g(row) for
  // these, in rising order. Throws std::overflow_error with the most that can be listed if a row has more.
  template <class F>
  void find(Found& f, F&& each_kept) const {
    const std::size_t n = f.rows.size();
    f.from.resize(n), f.count.resize(n), f.thread.resize(n);
    f.by_thread.resize(std::max(f.by_thread.size(), std::size_t(thread_count())));
    for (detail::FoundRows& mine : f.by_thread) mine.count = 0;
    each_chunk(n, [&](int chunk, std::size_t begin, std::size_t end) {
      detail::FoundRows& mine = f.by_thread[std::size_t(chunk)];
      std::vector<std::int32_t> more;  // remembered, though far away
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t p = std::size_t(f.rows[i]);
        f.thread[i] = chunk, f.from[i] = std::uint32_t(mine.count);
        std::size_t count = grid.find(p, T(near), mine), k = 0;
        more.clear();
        each_kept(p, [&](std::int32_t row) {
          const std::int32_t* rows = mine.rows.data() + f.from[i];
          while (k < count && rows[k] < row) ++k;
          if (k == count || rows[k] != row) more.push_back(row);
        });
        if (!more.empty()) {
          std::copy(more.begin(), more.end(), mine.room(more.size()));
          mine.count += more.size(), count += more.size();
          std::int32_t* rows = mine.rows.data() + f.from[i];
          std::inplace_merge(rows, rows + (count - more.size()), rows + count);
        }
        f.count[i] = std::uint32_t(count);
      }
    });
    if (std::any_of(f.count.begin(), f.count.end(), [](std::uint32_t c) { return c > Neighbours<T>::most; }))
      throw std::overflow_error(std::to_string(Neighbours<T>::most));
  }
  // find(f) with what the lists remember.
  void find(Found& f) const {
    find(f, [&](std::size_t p, auto&& g) {
      lists.each(p, [&](std::uint32_t e) {
        if (lists.hold[e] != T(0)) g(lists.row[e]);
      });
    });
  }
  // Write the lists of the rows in f, which are sorted.
  void write(const Found& f) {
    constexpr std::size_t lanes = group_rows<T>;
    std::vector<std::size_t> first;  // of each group
    for (std::size_t i = 0; i < f.rows.size(); ++i) {
      const std::size_t g = std::size_t(f.rows[i]) / lanes;
      if (i == 0 || std::size_t(f.rows[i - 1]) / lanes != g) first.push_back(i);
      lists.make_room(g, f.count[i]);
    }
    first.push_back(f.rows.size());
    each_chunk(first.size() - 1, [&](int, std::size_t begin, std::size_t end) {
      PairMemory<T> spare;
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t i = first[k]; i < first[k + 1]; ++i)
          lists.write(std::size_t(f.rows[i]), f.of(i), f.count[i], spare);
        lists.count_slots(std::size_t(f.rows[first[k]]) / lanes);
      }
    });
  }
  // Let pairs join and leave lists; `all` are sorted. Throws as find().
  void edit(const std::vector<PairChange>& all) {
    const auto group = [&](std::size_t i) { return std::size_t(all[i].row) / group_rows<T>; };
    std::vector<std::size_t> first;  // of each group
    std::size_t joins = 0;           // those of the row so far
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i == 0 || group(i) != group(i - 1)) first.push_back(i);
      joins = (i > 0 && all[i].row == all[i - 1].row ? joins : 0) + all[i].joins;
      const std::size_t wanted = lists.filled[std::size_t(all[i].row)] + joins;
      if (wanted > Neighbours<T>::most) throw std::overflow_error(std::to_string(Neighbours<T>::most));
      lists.make_room(group(i), wanted);
    }
    first.push_back(all.size());
    each_chunk(first.size() - 1, [&](int, std::size_t begin, std::size_t end) {
      PairMemory<T> spare;
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t i = first[k], j = i; i < first[k + 1]; i = j) {
          while (j < first[k + 1] && all[j].row == all[i].row) ++j;
          lists.edit(std::size_t(all[i].row), all.data() + i, all.data() + j, spare);
        }
        lists.count_slots(group(first[k]));
      }
    });
  }
};

// The mean velocity of all particles [m/s]; none if there is no finite one.
template <class T>
Vec3<double> mean_velocity(const ParticleState<T>& s) {
  Vec3<double> out{};
  for (int k = 0; s.count > 0 && k < 3; ++k) {
    double sum = 0;
    for (std::size_t p = 0; p < s.count; ++p) sum += double(s.v.column(k)[p]);
    out[k] = std::isfinite(sum) ? sum / double(s.count) : 0.0;
  }
  return out;
}

// List all pairs anew; `memory` is what is remembered of them, by the rows that are, each row's sorted. `shares_drift`: particles may be
// expected to go on as fast as they go in the mean. Throws std::domain_error with the birth number of a lost particle.
template <class T>
void list_all(const ParticleState<T>& s, Listing<T>& l, const PairMemory<T>& memory, bool shares_drift) {
  constexpr std::size_t lanes = group_rows<T>;
  l.drift = shares_drift ? mean_velocity(s) : Vec3<double>{}, l.elapsed = 0;
  l.grid.clear(l.near * (1 + 2 * l.most_way), s.count);
  auto& all = l.found;
  all.rows.resize(s.count);
  for (std::size_t p = 0; p < s.count; ++p) {
    all.rows[p] = std::int32_t(p);
    l.grid.put(std::int32_t(p), l.start_now(s, p), s.id[p]);
  }
  const bool known = memory.begin.size() == s.count + 1;
  l.find(all, [&](std::size_t p, auto&& g) {
    for (std::uint32_t n = known ? memory.begin[p] : 0; known && n < memory.begin[p + 1]; ++n)
      g(memory.row[n]);
  });
  l.lists.clear(s.count, [&](std::size_t g) {
    std::uint32_t most = 0;
    for (std::size_t p = g * lanes; p < std::min(s.count, (g + 1) * lanes); ++p)
      most = std::max(most, all.count[p]);
    return most;
  });
  l.write(all);
  if (!known) return;
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      for (std::uint32_t n = memory.begin[p]; n < memory.begin[p + 1]; ++n) {
        const std::uint32_t e = l.lists.find(p, memory.row[n]);
        if (e == l.lists.none) continue;
        l.lists.hold[e] = memory.values[n][0], l.lists.a[e] = memory.values[n][1];
        l.lists.b[e] = memory.values[n][2], l.lists.c[e] = memory.values[n][3];
      }
    }
  });
}

// Give the particles `moved` a new start, and list their pairs. They are sorted.
template <class T>
void list_moved(const ParticleState<T>& s, Listing<T>& l, const std::vector<std::int32_t>& moved) {
  if (moved.empty()) return;
  l.moves.resize(s.count, 0);
  for (const std::int32_t p : moved) {
    l.grid.put(p, l.start_now(s, std::size_t(p)), s.id[std::size_t(p)]);
    l.moves[std::size_t(p)] = 1;
  }
  l.found.rows = moved;
  l.find(l.found);
  // those that pairs join or leave
  std::vector<std::vector<PairChange>> parts(static_cast<std::size_t>(thread_count()));
  each_chunk(moved.size(), [&](int chunk, std::size_t begin, std::size_t end) {
    auto& mine = parts[std::size_t(chunk)];
    for (std::size_t i = begin; i < end; ++i) {
      const auto note = [&](std::int32_t q, bool joins) {
        if (!l.moves[std::size_t(q)]) mine.push_back({q, moved[i], joins});
      };
      const std::int32_t* now = l.found.of(i);
      const std::int32_t* last = now + l.found.count[i];
      l.lists.each(std::size_t(moved[i]), [&](std::uint32_t e) {
        while (now != last && *now < l.lists.row[e]) note(*now++, true);
        if (now != last && *now == l.lists.row[e])
          ++now;
        else
          note(l.lists.row[e], false);
      });
      while (now != last) note(*now++, true);
    }
  });
  for (const std::int32_t p : moved) l.moves[std::size_t(p)] = 0;
  l.changes.clear();
  for (const auto& part : parts) l.changes.insert(l.changes.end(), part.begin(), part.end());
  std::sort(l.changes.begin(), l.changes.end());
  l.write(l.found);
  l.edit(l.changes);
}

// Bond all pairs of particles of one source whose birth numbers are `first` or more and whose gap is at most `gap` of their
// radii: at rest as they lie. A bond of particles that overlap does not break before they part: none presses then.
template <class T>
void make_bonds(const ParticleState<T>& s, Neighbours<T>& lists, std::uint32_t first, T gap) {
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      lists.each(p, [&](std::uint32_t e) {
        const auto q = std::size_t(lists.row[e]);
        if (s.id[p] < first || s.id[q] < first || s.source[p] != s.source[q]) return;
        const T *r = s.radius.column(0), *limit = s.bond.column(0);
        T d2 = 0;
        for (int k = 0; k < 3; ++k) {
          const T d = s.x.column(k)[p] - s.x.column(k)[q];
          d2 += d * d;
        }
        const T radii = r[p] + r[q], overlap = radii - std::sqrt(d2);
        const T hold = T(0.5) * (limit[p] + limit[q]) * radii;
        if (overlap < -gap * radii || !(hold > T(0))) return;
        lists.hold[e] = std::max(hold, overlap), lists.a[e] = overlap, lists.b[e] = lists.c[e] = T(0);
      });
    }
  });
}

}  // namespace neve
