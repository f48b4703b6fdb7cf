// The step of the discrete element method: forces of pairs, then velocities, solids, compaction, positions.
#pragma once

#include "particles/sleep.hpp"

namespace neve {

// The constants of one run.
template <class T>
struct ParticleModel {
  ContactLaw<T> law;
  double ice = 917;  // density at which snow is compacted no more [kg/m3]
  SleepRule sleep;
  double hardening = 100;  // rise of density by which the yield pressure grows e-fold [kg/m3]
};

// Sums over the pairs of each particle.
template <class T>
struct PairSums {
  // First columns of: the force (3), the parts of forces across along +x +y +z (3) and along -x -y -z (3), forces across
  // [N], stiffness [N/m].
  static constexpr int force = 0, along = 3, against = 6, across = 9, stiffness = 10, count = 11;
  Columns<T> values{count};
};

// What a pass over the particles found.
struct ParticleReport {
  double speed = 0;     // largest [m/s]
  double stiffest = 0;  // largest sum of the stiffness of a particle's contacts over its mass [1/s2]
  bool finite = true;
  void merge(const ParticleReport& o) {
    speed = std::max(speed, o.speed), stiffest = std::max(stiffest, o.stiffest);
    finite = finite && o.finite;
  }
};

namespace detail {

// The forces on one group of rows, lane by lane.
template <class T>
class GroupForces {
 public:
  using R = Lanes<T>;
  using Sums = PairSums<T>;
  // `wakes` gets the groups of sleepers with which pairs are made or lost.
  GroupForces(const PairQuads<T>& quads, Neighbours<T>& lists, const ContactLaw<T>& law,
              std::vector<std::uint32_t>& wakes)
      : quads_(quads), lists_(lists), law_(law), wakes_(wakes) {}

  // `keeps`: whether pairs go on, or are only looked at.
  template <bool keeps = true>
  void of(std::size_t g, Columns<T>& out) {
    std::int32_t rows[width<R>];
    for (int l = 0; l < width<R>; ++l) rows[l] = std::int32_t(g * group_rows<T>) + l;
    place_ = gather_quartets<R>(quads_.place.data(), rows);
    motion_ = gather_quartets<R>(quads_.motion.data(), rows);
    grip_ = gather_quartets<R>(quads_.grip.data(), rows);
    R sums[Sums::count]{};
    std::uint32_t e = lists_.base[g];
    for (std::uint32_t n = lists_.slots[g]; n > 0; --n, e += width<R>) add<keeps>(e, sums);
    for (int k = 0; k < Sums::count; ++k) store(out.column(k) + g * group_rows<T>, sums[k]);
  }

 private:
  template <bool keeps>
  void add(std::uint32_t e, R* sums) {
    const R zero = splat<R>(0);
    const std::int32_t* rows = lists_.row.data() + e;
    const Quartets<R> place = gather_quartets<R>(quads_.place.data(), rows);
    const Vec3<R> x{place_.a - place.a, place_.b - place.b, place_.c - place.c};
    const R radii = place_.d + place.d;
    Pair<R> pair = pair_at(x, radii);
    const R hold = load<R>(lists_.hold.data() + e);
    if (!any((pair.overlap > T(0)) | negated(hold == T(0)))) return;
    const Quartets<R> motion = gather_quartets<R>(quads_.motion.data(), rows);
    const Vec3<R> v{motion_.a - motion.a, motion_.b - motion.b, motion_.c - motion.c};
    const R k = (abs(motion_.d) + abs(motion.d)) * T(0.5);
    set_motion(pair, v, k);
    const R rest = load<R>(lists_.a.data() + e);
    const auto was_bonded = hold > T(0);
    R now = select(was_bonded & (rest - pair.overlap > hold), zero, hold);
    const auto bonded = now > T(0);
    R across = select(bonded, bond_force(pair, rest, law_), zero);
    Vec3<R> force = pair.n * across;
    const auto touching = negated(bonded) & ((pair.overlap > T(0)) | (now < T(0)));
    auto active = bonded;
    if (any(touching)) {
      Memory<R> memory{now, {rest, load<R>(lists_.b.data() + e), load<R>(lists_.c.data() + e)}};
      active = bonded | (touching & touch(rows, pair, radii, touching, memory, across, force));
      now = memory.hold;
      if constexpr (keeps) {
        store(lists_.a.data() + e, memory.a.x);
        store(lists_.b.data() + e, memory.a.y);
        store(lists_.c.data() + e, memory.a.z);
      }
    }
    const auto changed = negated(now == hold);
    if (keeps && any(changed)) {
      store(lists_.hold.data() + e, now);
      note(rows, (hold == T(0)) | (now == T(0)) | (was_bonded & negated(bonded)),
           changed & (motion.d < T(0)));
    }
    for (int i = 0; i < 3; ++i) {
      const R normal = pair.n[i] * across;
      sums[Sums::force + i] += force[i];
      sums[Sums::along + i] += max(normal, zero);
      sums[Sums::against + i] += max(R(-normal), zero);
    }
    sums[Sums::across] += across;
    sums[Sums::stiffness] += select(active, k, zero);
  }

  // The contacts among the lanes `touching`: their forces join `across` and `force`. Returns which of them hold on.
  auto touch(const std::int32_t* rows, const Pair<R>& pair, const R& radii, const auto& touching,
             Memory<R>& memory, R& across, Vec3<R>& force) {
    const R zero = splat<R>(0);
    const Quartets<R> grip = gather_quartets<R>(quads_.grip.data(), rows);
    const R mu = mean_of(grip_.a, grip.a), bond = mean_of(grip_.b, grip.b) * radii;
    const auto was = memory.hold < T(0);
    R gap = max(R(-memory.hold), splat<R>(loose<T>));  // that is bridged
    gap = select(pair.overlap > bond, max(gap, bond), gap);
    const auto holds = pair.overlap > -gap;
    Vec3<R> spring = select(was, memory.a, Vec3<R>{zero, zero, zero});
    const R pressed = select(touching & holds, contact_force(pair, law_), zero);
    const Vec3<R> along = rub(spring, pair, pressed, mu, law_);
    across += pressed;
    force = force + select(touching & holds, pair.n * pressed + along, Vec3<R>{zero, zero, zero});
    memory.a = select(touching, select(holds, spring, Vec3<R>{zero, zero, zero}), memory.a);
    memory.hold = select(touching, select(holds, R(-gap), zero), memory.hold);
    return holds;
  }

  // Friction or cohesion of a pair: the mean, none where one of them has none.
  static R mean_of(const R& a, const R& b) {
    const R zero = splat<R>(0);
    return select((a > zero) & (b > zero), R((b + a) * T(0.5)), zero);
  }

  // Have the groups of `rows` woken where both masks say so.
  void note(const std::int32_t* rows, const auto& one, const auto& other) {
    const auto both = one & other;
    if (!any(both)) return;
    for (int l = 0; l < width<R>; ++l) {
      if (both[l]) wakes_.push_back(std::uint32_t(std::size_t(rows[l]) / group_rows<T>));
    }
  }

  const PairQuads<T>& quads_;
  Neighbours<T>& lists_;
  const ContactLaw<T> law_;
  std::vector<std::uint32_t>& wakes_;
  Quartets<R> place_, motion_, grip_;  // of the group
};

}  // namespace detail

// Sum the forces between particles on those that do not sleep; contacts are made and broken. Each pair is computed from both its
// sides, with forces that are opposite to the last bit. `wakes` gets the groups of sleepers whose pairs are made or lost.
template <class T>
void pair_forces(Neighbours<T>& lists, const ContactLaw<T>& law, const PairQuads<T>& quads,
                 const Groups<T>& groups, PairSums<T>& sums, std::vector<std::uint32_t>& wakes) {
  if (sums.values.size() != lists.rows) sums.values.resize(lists.rows);
  constexpr std::size_t chunk = 8;
  const std::vector<std::uint32_t>& awake = groups.awake;
  std::vector<std::vector<std::uint32_t>> parts((awake.size() + chunk - 1) / chunk);
  each_index(parts.size(), [&](std::size_t c) {
    detail::GroupForces<T> forces(quads, lists, law, parts[c]);
    for (std::size_t i = c * chunk; i < std::min(awake.size(), (c + 1) * chunk); ++i)
      forces.of(awake[i], sums.values);
  });
  for (const auto& part : parts) wakes.insert(wakes.end(), part.begin(), part.end());
}

// The sleeping groups beside particles that move, on which forces differ by more than `most` [m/s2] times the mass from those with
// which they fell asleep: something pushes them, or they hang on what was below them.
template <class T>
std::vector<std::uint32_t> unsettled(const ParticleState<T>& s, Neighbours<T>& lists,
                                     const ContactLaw<T>& law, const PairQuads<T>& quads,
                                     const Groups<T>& groups, PairSums<T>& sums, double most) {
  const std::vector<std::uint32_t> border = remind_sleepers(lists, groups);
  std::vector<char> pushed(border.size(), 0);
  each_index(border.size(), [&](std::size_t i) {
    const std::size_t g = border[i];
    std::vector<std::uint32_t> none;
    detail::GroupForces<T>(quads, lists, law, none).template of<false>(g, sums.values);
    for (std::size_t p = g * groups.lanes; p < detail::end_of_group(s, g); ++p) {
      double more2 = 0;
      for (int k = 0; k < 3; ++k) {
        const double more =
            double(sums.values.column(PairSums<T>::force + k)[p]) - double(s.rest.column(1 + k)[p]);
        more2 += more * more;
      }
      const double bound = most * double(s.m.column(0)[p]);
      pushed[i] = pushed[i] || !(more2 <= bound * bound);
    }
  });
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < border.size(); ++i) {
    if (pushed[i]) out.push_back(border[i]);
  }
  return out;
}

// How stiff the contacts and bonds of the particles that do not sleep are, and how fast these are.
template <class T>
ParticleReport stiffness_of(const ParticleState<T>& s, const Neighbours<T>& lists, const Groups<T>& groups) {
  const T *x = s.x.column(0), *y = s.x.column(1), *z = s.x.column(2), *r = s.radius.column(0);
  return merge_each<ParticleReport>(groups.awake.size(), [&](std::size_t i) {
    const std::size_t g = groups.awake[i];
    ParticleReport out;
    for (std::size_t p = g * groups.lanes; p < detail::end_of_group(s, g); ++p) {
      double sum = 0, v2 = 0;
      lists.each(p, [&](std::uint32_t e) {
        const auto q = std::size_t(lists.row[e]);
        const T dx = x[p] - x[q], dy = y[p] - y[q], dz = z[p] - z[q], radii = r[p] + r[q];
        if (lists.hold[e] != T(0) || dx * dx + dy * dy + dz * dz < radii * radii)
          sum += 0.5 * (double(s.k.column(0)[p]) + double(s.k.column(0)[q]));
      });
      for (int k = 0; k < 3; ++k) v2 += double(s.v.column(k)[p]) * double(s.v.column(k)[p]);
      out.stiffest = std::max(out.stiffest, sum / double(s.m.column(0)[p]));
      out.speed = std::max(out.speed, std::sqrt(v2));
      out.finite = out.finite && std::isfinite(sum + v2) && std::isfinite(x[p] + y[p] + z[p]);
    }
    return out;
  });
}

}  // namespace neve
