// A pass over the heat of the snow of one run.
#pragma once

#include "particles/heat/phase.hpp"
#include "particles/snow.hpp"

namespace neve {

// Let heat flow for dt [s] of motion among `solids`. Sleepers that it changes wake, and those beside them.
template <class T>
HeatReport pass_heat(ParticleSnow<T>& snow, const std::vector<Solid<T>>& solids, double dt) {
  snow.remind();
  std::vector<char> changed;
  ParticleState<T>& s = snow.state;
  const Neighbours<T>& lists = snow.listing.lists;
  const HeatReport report = pass_heat(snow.heat, solids, s, snow.listing.lists, snow.table, dt, changed);
  if (snow.groups.sleepers > 0) {
    std::vector<char> wakes(snow.groups.asleep.size(), 0);
    for (std::size_t p = 0; p < s.count; ++p) {
      if (!changed[p]) continue;
      wakes[p / snow.groups.lanes] = 1;
      lists.each(p, [&](std::uint32_t e) { wakes[std::size_t(lists.row[e]) / snow.groups.lanes] = 1; });
    }
    std::vector<std::uint32_t> rouse;
    for (std::size_t g = 0; g < wakes.size(); ++g) {
      if (wakes[g] && snow.groups.asleep[g]) rouse.push_back(std::uint32_t(g));
    }
    if (!rouse.empty()) wake(s, snow.listing.lists, snow.quads, snow.groups, rouse);
  }
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (changed[p]) snow.quads.set(s, p, false);
    }
  });
  return report;
}

}  // namespace neve
