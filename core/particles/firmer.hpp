// Bonds and contacts of particles that compaction has made stronger.
#pragma once

#include <algorithm>

#include "particles/advance.hpp"

namespace neve {

namespace detail {

// Have entry e of row p hold `ratio` times as much, unless it is stretched so far that the next step finds it broken: it stores nothing
// any more, and must not again.
template <class T>
void hold_more(const ParticleState<T>& s, Neighbours<T>& lists, std::size_t p, std::uint32_t e, T ratio) {
  const auto q = std::size_t(lists.row[e]);
  const double radii = double(s.radius.column(0)[p]) + double(s.radius.column(0)[q]);
  const T overlap = T(radii - distance(s, p, q));
  T& hold = lists.hold[e];
  const bool holds = hold > T(0) ? lists.a[e] - overlap <= hold : hold < -loose<T> && overlap > hold;
  if (holds) hold *= ratio;
}

}  // namespace detail

// Let the bonds and contacts of the particles `firmer` bear more as these have become stronger, and forget those particles. No bond
// stores or pulls more than before.
template <class T>
void strengthen(const ParticleState<T>& s, const std::vector<ContactMaterial>& table, Neighbours<T>& lists,
                std::vector<StepEvents::Firmer>& firmer) {
  if (firmer.empty()) return;
  std::sort(firmer.begin(), firmer.end());
  for (const StepEvents::Firmer& f : firmer) {
    const auto p = std::size_t(f.row);
    const double mine = strength_of(s, table, p);
    lists.each(p, [&](std::uint32_t e) {
      if (lists.hold[e] == T(0)) return;
      const auto q = std::size_t(lists.row[e]);
      const auto too = std::lower_bound(firmer.begin(), firmer.end(), StepEvents::Firmer{lists.row[e], 0});
      const bool both = too != firmer.end() && too->row == lists.row[e];
      if (both && q < p) return;  // done
      const double other = strength_of(s, table, q), before = f.before + (both ? too->before : other);
      if (!(before > 0)) return;
      const T ratio = T((mine + other) / before);
      detail::hold_more(s, lists, p, e, ratio);
      const std::uint32_t mirror = lists.find(q, f.row);
      if (mirror != lists.none) detail::hold_more(s, lists, q, mirror, ratio);
    });
  }
  firmer.clear();
}

}  // namespace neve
