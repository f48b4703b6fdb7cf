// The snow of one run: particles, pairs, who sleeps; what is done before and after steps.
#pragma once

#include "heat/enthalpy.hpp"
#include "particles/advance.hpp"
#include "particles/clearance.hpp"

namespace neve {

template <class T>
struct ParticleSnow {
  ParticleModel<T> model;
  HeatModel heat;
  std::vector<ContactMaterial> table;
  ConstantBounds bounds;  // of the table's constants
  ParticleState<T> state;
  Listing<T> listing;
  PairQuads<T> quads;
  PairSums<T> sums;
  Groups<T> groups;
  Clearance<T> clearance;
  StepEvents events;
  std::vector<detail::ChunkResult<T>> parts;  // of a step: memory that is used again
  std::vector<Exchange> exchanged;
  PairMemory<T> carried;   // of pairs that are not listed yet
  std::int64_t wide = -1;  // groups that were wide when rows were last sorted; below zero: they never were

  // Whether something has to be done before the next step.
  bool is_due() const { return events.any() || groups.sleepers > 0; }
  // What is remembered of all pairs, listed or not.
  PairMemory<T> memory() const { return listing.made_for(state.count) ? memory_of(listing.lists) : carried; }
  // Every row knows what is remembered of its pairs, sleepers as well.
  void remind() {
    if (listing.made_for(state.count)) remind_sleepers(listing.lists, groups);
  }
};

namespace detail {

// Groups that are wider than this many times the reach of pairs make steps slow.
inline constexpr double wide_group = 4;

// How near a moving solid wakes snow, in radii; a radius farther snow falls asleep again.
inline constexpr double solid_play = 1.5;

// How many steps apart it is seen what falls asleep, and whether the forces on sleepers have changed by so many weights.
inline constexpr std::int64_t steps_unseen = 8;
inline constexpr double most_weight = 8;

template <class T>
std::int64_t wide_groups(const ParticleState<T>& s, double near) {
  const std::size_t count = (s.count + group_rows<T> - 1) / group_rows<T>;
  std::vector<std::int64_t> parts(static_cast<std::size_t>(thread_count()), 0);
  each_chunk(count, [&](int chunk, std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g)
      parts[std::size_t(chunk)] +=
          double(ball_of(s, g * group_rows<T>, end_of_group(s, g)).radius) > 0.5 * wide_group * near;
  });
  std::int64_t sum = 0;
  for (const std::int64_t part : parts) sum += part;
  return sum;
}

// Sort the rows, sleepers first, and take memory along.
template <class T>
void sort_rows(ParticleSnow<T>& snow, PairMemory<T>& memory) {
  ParticleState<T>& s = snow.state;
  const auto order = order_along_curve(s, 0.5 * snow.listing.near,
                                       [&](std::size_t p) { return std::isinf(s.rest.column(0)[p]); });
  std::vector<std::int32_t> row_now(s.count);
  for (std::size_t i = 0; i < s.count; ++i) row_now[order[i]] = std::int32_t(i);
  reorder(s, order);
  if (memory.begin.size() <= 1) return;
  PairMemory<T> now;
  for (std::size_t i = 0; i < s.count; ++i) {
    const std::size_t p = order[i];
    if (p + 1 < memory.begin.size()) {
      std::vector<std::pair<std::int32_t, std::uint32_t>> sorted;
      for (std::uint32_t e = memory.begin[p]; e < memory.begin[p + 1]; ++e)
        sorted.emplace_back(row_now[std::size_t(memory.row[e])], e);
      std::sort(sorted.begin(), sorted.end());
      for (const auto& [row, e] : sorted) now.row.push_back(row), now.values.push_back(memory.values[e]);
    }
    now.begin.push_back(std::uint32_t(now.row.size()));
  }
  memory = std::move(now);
}

// List all pairs anew, with what is remembered of them.
template <class T>
void list_anew(ParticleSnow<T>& snow, const PairMemory<T>& memory) {
  list_all(snow.state, snow.listing, memory, snow.groups.sleepers == 0);
}

// Rows that have moved away from where their neighbours were listed, or that someone has moved.
template <class T>
std::vector<std::int32_t> moved_rows(const ParticleSnow<T>& snow) {
  const ParticleState<T>& s = snow.state;
  const Vec3<T> shift = snow.listing.shift();
  std::vector<std::vector<std::int32_t>> parts(static_cast<std::size_t>(thread_count()));
  each_chunk(s.count, [&](int chunk, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Quartet<T>& start = snow.listing.grid.start(p);
      const T x = s.x.column(0)[p] - shift.x - start.a, y = s.x.column(1)[p] - shift.y - start.b,
              z = s.x.column(2)[p] - shift.z - start.c;
      if (!(x * x + y * y + z * z <= start.d * start.d)) parts[std::size_t(chunk)].push_back(std::int32_t(p));
    }
  });
  std::vector<std::int32_t> out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

// Whether particles no longer go on as fast as they were expected to: what has landed would be listed again and again.
template <class T>
bool drift_is_over(const ParticleSnow<T>& snow) {
  const Vec3<double>& drift = snow.listing.drift;
  if (!(dot(drift, drift) > 0)) return false;
  const Vec3<double> off = mean_velocity(snow.state) - drift;
  return dot(off, off) > 0.25 * dot(drift, drift);
}

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

// List the pairs of rows that have moved.
template <class T>
void relist(ParticleSnow<T>& snow, const std::vector<std::int32_t>& moved) {
  if (2 * moved.size() > snow.state.count && snow.groups.sleepers == 0)
    list_anew(snow, memory_of(snow.listing.lists));
  else
    list_moved(snow.state, snow.listing, moved);
}

}  // namespace detail

// Get ready for steps of dt [s] after the state may have been written to: see who sleeps, sort the rows if they are in disorder,
// list all pairs within `near` [m]. Throws std::domain_error with the birth number of a particle that is lost.
template <class T>
void prepare(ParticleSnow<T>& snow, double near, double dt) {
  ParticleState<T>& s = snow.state;
  Listing<T>& listing = snow.listing;
  snow.remind();
  const bool may_sleep = snow.model.sleep.way > 0 && snow.model.sleep.may_sleep;
  see_sleepers(s, snow.groups, may_sleep);
  std::vector<std::int32_t> moved;
  if (listing.made_for(s.count)) moved = detail::moved_rows(snow);
  for (const std::int32_t p : moved) {  // sleepers that someone has moved wake
    const std::size_t g = std::size_t(p) / snow.groups.lanes;
    if (!snow.groups.asleep[g]) continue;
    snow.groups.asleep[g] = 0;
    for (std::size_t q = g * snow.groups.lanes; q < detail::end_of_group(s, g); ++q) detail::begin_rest(s, q);
  }
  snow.groups.count();
  const bool made = listing.made_for(s.count) && listing.near == near;
  const bool wasteful = listing.lists.wasted > listing.lists.size() / 2;
  const std::int64_t allowed = 2 * snow.wide + std::int64_t(snow.groups.asleep.size() / 16);
  const bool sorts = snow.wide < 0 || detail::wide_groups(s, near) > allowed;
  listing.dt = dt;
  if (!made || wasteful || sorts || detail::drift_is_over(snow)) {
    PairMemory<T> memory = snow.memory();
    snow.carried = {};
    listing.near = near;
    if (sorts) {
      detail::sort_rows(snow, memory);
      see_sleepers(s, snow.groups, may_sleep);
      snow.wide = detail::wide_groups(s, near);
    }
    detail::list_anew(snow, memory);
  } else {
    detail::relist(snow, moved);
  }
  snow.quads.resize(s.count);
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) snow.quads.set(s, p, snow.groups.asleep[p / snow.groups.lanes]);
  });
  detail::set_all_balls(s, snow.groups);
  snow.clearance.clear();
  snow.events.clear();
}

// The groups of `calm`, sorted, that may fall asleep: what does not rest of them swings, and no moving solid is near.
template <class T>
std::vector<std::uint32_t> drowsy(const ParticleSnow<T>& snow, const Model<T>& world,
                                  std::vector<std::uint32_t> calm, double play) {
  std::sort(calm.begin(), calm.end());
  std::vector<char> may(calm.size(), 0);
  each_index(calm.size(), [&](std::size_t i) {
    const std::size_t g = calm[i];
    if (!only_swings(snow.state, snow.listing.lists, g, snow.model.sleep)) return;
    const Around<T> ball =
        detail::ball_of(snow.state, g * snow.groups.lanes, detail::end_of_group(snow.state, g));
    may[i] = !solid_moves_near(world, snow.state, g, ball, play);
  });
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < calm.size(); ++i) {
    if (may[i]) out.push_back(calm[i]);
  }
  return out;
}

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

// After step number `steps`: list the pairs of what has moved, wake what was pushed or what a solid comes to. Now and then put to
// sleep what has rested, and see whether forces on sleepers have changed.
template <class T>
void renew(ParticleSnow<T>& snow, const Model<T>& world, std::int64_t steps) {
  ParticleState<T>& s = snow.state;
  StepEvents& events = snow.events;
  const bool sees = steps % detail::steps_unseen == 0;
  const double play = detail::solid_play * snow.bounds.radius;
  strengthen(s, snow.table, snow.listing.lists, events.firmer);
  if (!std::is_sorted(events.moved.begin(), events.moved.end()))
    std::sort(events.moved.begin(), events.moved.end());
  detail::relist(snow, events.moved);
  if (snow.groups.sleepers > 0) {
    const auto met = snow.clearance.met(world, s, snow.groups, play);
    events.wakes.insert(events.wakes.end(), met.begin(), met.end());
    if (sees) {
      const double most = detail::most_weight * std::sqrt(double(dot(world.gravity, world.gravity))) +
                          snow.model.sleep.way / (snow.model.sleep.after * snow.model.sleep.after);
      const auto pushed =
          unsettled(s, snow.listing.lists, snow.model.law, snow.quads, snow.groups, snow.sums, most);
      events.wakes.insert(events.wakes.end(), pushed.begin(), pushed.end());
    }
  }
  std::sort(events.wakes.begin(), events.wakes.end());
  events.wakes.erase(std::unique(events.wakes.begin(), events.wakes.end()), events.wakes.end());
  if (!events.wakes.empty()) wake(s, snow.listing.lists, snow.quads, snow.groups, events.wakes);
  const auto calm = sees ? drowsy(snow, world, std::move(events.calm), play + snow.bounds.radius)
                         : std::vector<std::uint32_t>();
  if (!calm.empty()) {
    const bool drifts = snow.groups.sleepers == 0 && dot(snow.listing.drift, snow.listing.drift) > 0;
    put_to_sleep(s, snow.listing.lists, snow.quads, snow.groups, snow.sums.values, calm);
    for (const std::uint32_t g : calm) snow.clearance.clear(g / snow.groups.in_crowd);
    if (drifts) detail::list_anew(snow, memory_of(snow.listing.lists));
  }
  events.clear();
}

// Take one step of dt [s] among the solids of `world`, with its gravity.
template <class T>
ParticleReport take_step(ParticleSnow<T>& snow, const Model<T>& world, double dt) {
  pair_forces(snow.listing.lists, snow.model.law, snow.quads, snow.groups, snow.sums, snow.events.wakes);
  const ParticleReport report = advance(snow.model, snow.table, world, snow.state, snow.listing, snow.quads,
                                        snow.groups, snow.sums, dt, snow.exchanged, snow.events, snow.parts);
  snow.model.law.dt = T(dt);
  return report;
}

}  // namespace neve
