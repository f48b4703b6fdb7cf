// Particles that come and go while a run goes on.
#pragma once

#include "particles/measure.hpp"
#include "particles/snow.hpp"

namespace neve {

namespace detail {

// What `memory` holds of the pairs among the rows `kept`, which rise, by their new rows, with `more` rows after them of which
// nothing is remembered. `bereft` gets the new rows of those that had a pair with a row that is gone.
template <class T>
PairMemory<T> memory_of_kept(const PairMemory<T>& memory, const std::vector<std::uint32_t>& kept,
                             std::size_t count, std::size_t more, std::vector<std::uint32_t>& bereft) {
  std::vector<std::int32_t> row_now(count, -1);
  for (std::size_t i = 0; i < kept.size(); ++i) row_now[kept[i]] = std::int32_t(i);
  PairMemory<T> now;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    bool lost = false;
    for (std::uint32_t e = memory.begin[kept[i]]; e < memory.begin[kept[i] + 1]; ++e) {
      const std::int32_t row = row_now[std::size_t(memory.row[e])];
      lost = lost || row < 0;
      if (row >= 0) now.row.push_back(row), now.values.push_back(memory.values[e]);
    }
    if (lost) bereft.push_back(std::uint32_t(i));
    now.begin.push_back(std::uint32_t(now.row.size()));
  }
  now.begin.resize(kept.size() + more + 1, now.begin.back());
  return now;
}

}  // namespace detail

// Make `now` the snow of `before` with its rows `kept`, which rise, and `more` fresh ones after them. Pairs are not listed then:
// prepare() does that. What rested on something that is gone wakes. `before` has listed its pairs, or come from here as well.
template <class T>
void take_over(ParticleSnow<T>& now, ParticleSnow<T>& before, const std::vector<std::uint32_t>& kept,
               std::size_t more) {
  before.remind();
  now.model = before.model, now.heat = before.heat, now.table = before.table, now.bounds = before.bounds;
  now.exchanged = before.exchanged;
  now.wide = before.groups.sleepers > 0 ? -1 : before.wide;  // what sleeps stays together
  now.state.resize(kept.size() + more);
  std::vector<const void*> columns;
  before.state.each_column([&](const auto* column) { columns.push_back(column); });
  std::size_t next = 0;
  now.state.each_column([&](auto* to) {
    const auto* from = static_cast<decltype(to)>(const_cast<void*>(columns[next++]));
    each_chunk(kept.size(), [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) to[i] = from[kept[i]];
    });
  });
  std::vector<std::uint32_t> bereft;
  now.carried = detail::memory_of_kept(before.memory(), kept, before.state.count, more, bereft);
  for (const std::uint32_t p : bereft) detail::begin_rest(now.state, p);
}

// Bond particles whose birth numbers are `first` or more to what they are born beside: to those of their own source that are at most
// `gap` of their radii's sum away, and to all others that they lie in, until they part. So they are born without stress.
// Sleepers that they lie in wake.
template <class T>
void bond_newborn(ParticleSnow<T>& snow, std::uint32_t first, T gap) {
  ParticleState<T>& s = snow.state;
  Neighbours<T>& lists = snow.listing.lists;
  std::vector<std::vector<std::uint32_t>> parts(static_cast<std::size_t>(thread_count()));
  each_chunk(s.count, [&](int chunk, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      lists.each(p, [&](std::uint32_t e) {
        const auto q = std::size_t(lists.row[e]);
        if (s.id[p] < first && s.id[q] < first) return;
        const T *r = s.radius.column(0), *limit = s.bond.column(0), radii = r[p] + r[q];
        const T overlap = T(double(radii) - detail::distance(s, p, q));
        const bool own = s.source[p] == s.source[q];
        if (overlap <= (own ? -gap * radii : T(0))) return;
        const T hold = std::max(overlap, own ? T(0.5) * (limit[p] + limit[q]) * radii : T(0));
        if (!(hold > T(0))) return;
        lists.hold[e] = hold, lists.a[e] = overlap, lists.b[e] = lists.c[e] = T(0);
        if (snow.groups.asleep[p / snow.groups.lanes])
          parts[std::size_t(chunk)].push_back(std::uint32_t(p / snow.groups.lanes));
      });
    }
  });
  std::vector<std::uint32_t> wakes;
  for (const auto& part : parts) wakes.insert(wakes.end(), part.begin(), part.end());
  wakes.erase(std::unique(wakes.begin(), wakes.end()), wakes.end());
  if (!wakes.empty()) wake(s, lists, snow.quads, snow.groups, wakes);
}

}  // namespace neve
