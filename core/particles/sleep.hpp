// Snow at rest that is not stepped (docs/particles.md, Sleep).
//
// Particles sleep by groups: rows that are stepped together. Sleepers stay where they are, with the stress that they have, and
// particles that move push against them as against something that does not give way. What is remembered of a pair of one
// that moves and one that sleeps is kept by the former; the other gets it when it wakes, or when someone asks.
#pragma once

#include "cpu/fields.hpp"
#include "mpm/model.hpp"
#include "particles/listing.hpp"
#include "particles/solid_contact.hpp"

namespace neve {

// When particles sleep.
struct SleepRule {
  double way = 0;    // what stays this near to a place for the time `after` rests; zero: nothing sleeps [m]
  double after = 0;  // [s]
  double slow = 0;   // what does not rest, but hangs on what does, may sleep with it if it is slower [m/s]
  static constexpr double share = 0.75;  // of a group that must rest
  bool may_sleep = true;                 // now
};

// Which groups sleep. `awake` are the others, in rising order.
template <class T>
struct Groups {
  static constexpr std::size_t lanes = group_rows<T>, in_crowd = 64;
  std::vector<char> asleep;
  std::vector<std::uint32_t> awake;
  std::vector<Around<T>> ball;        // around each sleeping group, its particles' radii included
  std::vector<Around<T>> crowd_ball;  // around those of 64 groups; a radius below zero: none sleeps
  std::size_t sleepers = 0;           // groups

  void count() {
    awake.clear();
    for (std::size_t g = 0; g < asleep.size(); ++g) {
      if (!asleep[g]) awake.push_back(std::uint32_t(g));
    }
    sleepers = asleep.size() - awake.size();
  }
};

namespace detail {

inline constexpr double asleep_rest = std::numeric_limits<double>::infinity();

template <class T>
std::size_t end_of_group(const ParticleState<T>& s, std::size_t g) {
  return std::min(s.count, (g + 1) * group_rows<T>);
}

template <class T>
Around<T> ball_of(const ParticleState<T>& s, std::size_t begin, std::size_t end) {
  Vec3<T> low{}, high{};
  T radius = 0;
  for (std::size_t p = begin; p < end; ++p) {
    for (int k = 0; k < 3; ++k) {
      const T x = s.x.column(k)[p];
      low[k] = p == begin ? x : std::min(low[k], x), high[k] = p == begin ? x : std::max(high[k], x);
    }
    radius = std::max(radius, s.radius.column(0)[p]);
  }
  const Vec3<T> half = (high - low) * T(0.5);
  return {low + half, std::sqrt(dot(half, half)) + radius};
}

// Make the balls around the sleeping groups of `crowd`.
template <class T>
void set_balls(const ParticleState<T>& s, Groups<T>& groups, std::size_t crowd) {
  const std::size_t begin = crowd * groups.in_crowd,
                    end = std::min(groups.asleep.size(), begin + groups.in_crowd);
  Vec3<T> low{}, high{};
  bool first = true;
  for (std::size_t g = begin; g < end; ++g) {
    if (!groups.asleep[g]) continue;
    const Around<T> ball = groups.ball[g] = ball_of(s, g * groups.lanes, end_of_group(s, g));
    for (int k = 0; k < 3; ++k) {
      const T a = ball.middle[k] - ball.radius, b = ball.middle[k] + ball.radius;
      low[k] = first ? a : std::min(low[k], a), high[k] = first ? b : std::max(high[k], b);
    }
    first = false;
  }
  const Vec3<T> half = (high - low) * T(0.5);
  groups.crowd_ball[crowd] = {low + half, first ? T(-1) : std::sqrt(dot(half, half))};
}

template <class T>
void set_all_balls(const ParticleState<T>& s, Groups<T>& groups) {
  groups.ball.resize(groups.asleep.size());
  groups.crowd_ball.resize((groups.asleep.size() + groups.in_crowd - 1) / groups.in_crowd);
  each_chunk(groups.crowd_ball.size(), [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) set_balls(s, groups, k);
  });
}

// Let particle p begin to rest anew.
template <class T>
void begin_rest(ParticleState<T>& s, std::size_t p) {
  s.rest.column(0)[p] = T(0);
  for (int k = 0; k < 3; ++k) s.rest.column(1 + k)[p] = s.x.column(k)[p];
}

template <class T>
bool moves(const Solid<T>& solid) {
  const auto any = [](const Vec3<T>& a) { return dot(a, a) > T(0); };
  return solid.body >= 0 || any(solid.velocity) || any(solid.omega) || any(solid.belt);
}

}  // namespace detail

// See which groups sleep: those all of whose particles do, without a velocity that someone has written. Others wake.
template <class T>
void see_sleepers(ParticleState<T>& s, Groups<T>& groups, bool may_sleep) {
  groups.asleep.assign((s.count + groups.lanes - 1) / groups.lanes, 0);
  each_chunk(groups.asleep.size(), [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g) {
      bool all = may_sleep, some = false;
      for (std::size_t p = g * groups.lanes; p < detail::end_of_group(s, g); ++p) {
        const bool sleeps = std::isinf(s.rest.column(0)[p]);
        bool still = true;
        for (int k = 0; k < 3; ++k) still = still && s.v.column(k)[p] == T(0);
        all = all && sleeps && still, some = some || sleeps;
      }
      groups.asleep[g] = all;
      for (std::size_t p = g * groups.lanes; some && !all && p < detail::end_of_group(s, g); ++p) {
        if (std::isinf(s.rest.column(0)[p])) detail::begin_rest(s, p);
      }
    }
  });
  groups.count();
}

// Give sleepers what is remembered of their pairs with particles that move. Returns their groups, sorted.
template <class T>
std::vector<std::uint32_t> remind_sleepers(Neighbours<T>& lists, const Groups<T>& groups) {
  if (groups.sleepers == 0) return {};
  std::vector<std::vector<std::uint32_t>> parts(static_cast<std::size_t>(thread_count()));
  each_chunk(groups.awake.size(), [&](int chunk, std::size_t begin, std::size_t end) {
    auto& mine = parts[std::size_t(chunk)];
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t first = groups.awake[i] * groups.lanes,
                        last = std::min(lists.rows, first + groups.lanes);
      for (std::size_t p = first; p < last; ++p) {
        lists.each(p, [&](std::uint32_t e) {
          const auto q = std::size_t(lists.row[e]);
          if (!groups.asleep[q / groups.lanes]) return;
          const std::uint32_t there = lists.find(q, std::int32_t(p));
          if (there != lists.none) lists.copy_memory(e, there);
          if (mine.empty() || mine.back() != q / groups.lanes)
            mine.push_back(std::uint32_t(q / groups.lanes));
        });
      }
    }
  });
  std::vector<std::uint32_t> out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Wake the groups `wakes`, sorted and different; of them, those that sleep.
template <class T>
void wake(ParticleState<T>& s, Neighbours<T>& lists, PairQuads<T>& quads, Groups<T>& groups,
          const std::vector<std::uint32_t>& wakes) {
  const auto each_row = [&](auto&& f) {
    for (const std::uint32_t g : wakes) {
      if (!groups.asleep[g]) continue;
      for (std::size_t p = g * groups.lanes; p < detail::end_of_group(s, g); ++p) f(p);
    }
  };
  each_row([&](std::size_t p) {
    lists.each(p, [&](std::uint32_t e) {
      const auto q = std::size_t(lists.row[e]);
      if (groups.asleep[q / groups.lanes]) return;
      const std::uint32_t there = lists.find(q, std::int32_t(p));
      if (there != lists.none)
        lists.copy_memory(there, e);
      else
        lists.hold[e] = T(0);  // lost meanwhile
    });
  });
  each_row([&](std::size_t p) { detail::begin_rest(s, p), quads.set(s, p, false); });
  for (const std::uint32_t g : wakes) groups.asleep[g] = 0;
  groups.count();
}

// Whether what does not rest of group g is slow, and held by something that rests: loose ends that swing.
template <class T>
bool only_swings(const ParticleState<T>& s, const Neighbours<T>& lists, std::size_t g,
                 const SleepRule& rule) {
  const T* rest = s.rest.column(0);
  for (std::size_t p = g * group_rows<T>; p < detail::end_of_group(s, g); ++p) {
    if (rest[p] >= T(rule.after)) continue;
    double v2 = 0;
    for (int k = 0; k < 3; ++k) v2 += double(s.v.column(k)[p]) * double(s.v.column(k)[p]);
    bool held = false;
    lists.each(p, [&](std::uint32_t e) {
      held = held || (lists.hold[e] != T(0) && rest[std::size_t(lists.row[e])] >= T(rule.after));
    });
    if (!held || !(v2 < rule.slow * rule.slow)) return false;
  }
  return true;
}

// Put the awake groups `calm` to sleep; the first columns of `forces` are those on them.
template <class T>
void put_to_sleep(ParticleState<T>& s, Neighbours<T>& lists, PairQuads<T>& quads, Groups<T>& groups,
                  const Columns<T>& forces, const std::vector<std::uint32_t>& calm) {
  for (const std::uint32_t g : calm) {
    for (std::size_t p = g * groups.lanes; p < detail::end_of_group(s, g); ++p) {
      s.rest.column(0)[p] = T(detail::asleep_rest);
      for (int k = 0; k < 3; ++k) s.rest.column(1 + k)[p] = forces.column(k)[p];
      for (int k = 0; k < 3; ++k) s.v.column(k)[p] = T(0);
      quads.set(s, p, true);
      lists.each(p, [&](std::uint32_t e) {
        const auto q = std::size_t(lists.row[e]);
        if (!groups.asleep[q / groups.lanes]) return;
        const std::uint32_t there = lists.find(q, std::int32_t(p));
        if (there != lists.none) lists.copy_memory(e, there);
      });
    }
  }
  for (const std::uint32_t g : calm) groups.asleep[g] = 1;
  groups.count();
  std::size_t last = ~std::size_t(0);
  for (const std::uint32_t g : calm) {
    if (g / groups.in_crowd != last) detail::set_balls(s, groups, g / groups.in_crowd);
    last = g / groups.in_crowd;
  }
}

// Whether a solid that moves is within `play` [m] of a particle of group g, which `ball` is around.
template <class T>
bool solid_moves_near(const Model<T>& world, const ParticleState<T>& s, std::size_t g, const Around<T>& ball,
                      double play) {
  using R = Lanes<T>;
  const std::size_t p = g * group_rows<T>;
  const int count = int(detail::end_of_group(s, g) - p);
  for (const Solid<T>& solid : world.solids) {
    if (!detail::moves(solid) || !is_near(solid, ball.middle, T(ball.radius + T(play)))) continue;
    const R phi = surface(solid, load_vector<R>(s.x, p, count)).phi;
    const R gap = phi - load<R>(s.radius.column(0) + p, count);
    if (any(first_lanes<R>(count) & (gap <= T(play)))) return true;
  }
  return false;
}

}  // namespace neve
