// Neighbour lists (Verlet 1967): of each particle those within reach, and what is remembered of each pair.
#pragma once

#include "neighbours/search.hpp"
#include "particles/contact.hpp"
#include "particles/state.hpp"

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

// Where `row` stands among `count` rows, or count.
inline std::uint32_t place_of(const std::int32_t* rows, std::uint32_t count, std::int32_t row) {
  std::uint32_t at = 0, found = 0;
  for (std::uint32_t n = 0; n < count; ++n) {
    const std::uint32_t here = rows[n] == row;
    at += here * n, found += here;
  }
  return found ? at : count;
}

// The rows within reach of each particle, into lists without memory.
template <class T>
void find_neighbours(const ParticleState<T>& s, const Cells& cells, Neighbours<T>& lists,
                     std::vector<FoundRows>& found) {
  find_rows(s, cells, s, cells, T(lists.reach * lists.reach), found, lists.begin, [&](std::size_t n) {
    lists.resize(n);
    return lists.row.data();
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
  std::vector<detail::FoundRows> found;
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
  reorder(s, room.order);
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
