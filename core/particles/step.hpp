// The step of the discrete element method: forces of pairs, then velocities, solids, compaction, positions.
#pragma once

#include "particles/sleep.hpp"

namespace neve {

// The constants of one run.
template <class T>
struct ParticleModel {
  ContactLaw<T> law;
  double ice = ice_density;  // density at which snow is compacted no more [kg/m3]
  SleepRule sleep;
  double hardening = 100;  // rise of density by which the yield pressure grows e-fold [kg/m3]
};

// Sums over the pairs of each particle.
template <class T>
struct PairSums {
  // First columns of: the force (3), the parts of forces across along +x +y +z (3) and along -x -y -z (3), forces across
  // [N]; stiffness [N/m]: `springs`, the sum of w n n^T (xx yy zz xy xz yz), and `shear`, that of what acts in every direction.
  // And of what contacts with water are damped beyond law.damping: the sum of the dampers [N s/m], the longest damper time [s].
  static constexpr int force = 0, along = 3, against = 6, across = 9, springs = 10, shear = 16, wet = 17,
                       longest = 18, count = 19;
  Columns<T> values{count};
};

// What a pass over the particles found.
struct ParticleReport {
  double speed = 0;     // largest [m/s]
  double stiffest = 0;  // largest sum of the stiffness of a particle's contacts over its mass [1/s2]
  double rate = 0;      // largest of `stable_rate` [1/s]
  bool finite = true;
  void merge(const ParticleReport& o) {
    speed = std::max(speed, o.speed), stiffest = std::max(stiffest, o.stiffest),
    rate = std::max(rate, o.rate);
    finite = finite && o.finite;
  }
};

// The inverse of the longest step that is stable for particles whose springs answer a displacement u with at most stiffness u,
// and dampers a velocity with at most damper v, both over the mass [1/s2, 1/s], while all other particles stay.
//
// The energy of a pair's spring is k (n.u_i - n.u_j)^2 / 2 <= k (n.u_i)^2 + k (n.u_j)^2: so all springs together are at most
// twice as stiff as those of each particle alone, dampers likewise. Symplectic Euler is stable while dt^2 K + 2 dt C < 4 M, which
// holds where dt^2 stiffness / 2 + dt damper < 1 for each particle.
template <class R>
inline R stable_rate(const R& stiffness, const R& damper) {
  using T = scalar_t<R>;
  return (damper + sqrt(R(damper * damper + stiffness * T(2)))) * T(0.5);
}

// At most the largest eigenvalue of a symmetric matrix xx yy zz xy xz yz (Wolkowicz and Styan 1980): from the mean of all three
// and their standard deviation.
template <class R>
inline R largest_eigenvalue(const R* a) {
  using T = scalar_t<R>;
  const R mean = (a[0] + a[1] + a[2]) * T(1.0 / 3);
  const R x = a[0] - mean, y = a[1] - mean, z = a[2] - mean;
  const R squares = x * x + y * y + z * z + (a[3] * a[3] + a[4] * a[4] + a[5] * a[5]) * T(2);
  return mean + sqrt(R(squares * T(2.0 / 3)));
}

// `stable_rate` of particles of mass m with these PairSums. A contact's spring is k across and t k along it: t k in every direction,
// and (1 - t) k across. Its dampers are at most `damping` k in every direction, those of a bond `damping` k across. What dampers
// of water have beyond that acts across: all of it one way, or as much as all springs do in the longest of their times.
template <class R>
inline R rate_of(const R* sums, const R& m, const ContactLaw<scalar_t<R>>& law) {
  using T = scalar_t<R>;
  using Sums = PairSums<T>;
  const R across = largest_eigenvalue(sums + Sums::springs), shear = sums[Sums::shear];
  const R inv = T(1) / m;
  const R stiffness = across + shear;
  const R dampers = (across + shear * (T(1) / law.tangential)) * law.damping +
                    min(sums[Sums::wet], R(stiffness * sums[Sums::longest]));
  return stable_rate(R(stiffness * inv), R(dampers * inv));
}

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
    R along = zero;
    if (any(touching)) {
      Memory<R> memory{now, {rest, load<R>(lists_.b.data() + e), load<R>(lists_.c.data() + e)}};
      active = bonded | (touching & touch(rows, pair, radii, touching, memory, across, force, along, sums));
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
    add_stiffness(pair, select(active, k, zero), along, sums);
  }

  // Springs of the stiffness k [N/m], of which the share `along` acts in every direction.
  void add_stiffness(const Pair<R>& pair, const R& k, const R& along, R* sums) const {
    const R shear = k * along, w = k - shear;
    const Vec3<R> wn = pair.n * w;
    R* springs = sums + Sums::springs;
    springs[0] += wn.x * pair.n.x, springs[1] += wn.y * pair.n.y, springs[2] += wn.z * pair.n.z;
    springs[3] += wn.x * pair.n.y, springs[4] += wn.x * pair.n.z, springs[5] += wn.y * pair.n.z;
    sums[Sums::shear] += shear;
  }

  // The contacts among the lanes `touching`: their forces join `across` and `force`, the share of their stiffness that acts in
  // every direction is `stiff`, and dampers of water join `sums`. Returns which of them hold on.
  auto touch(const std::int32_t* rows, const Pair<R>& pair, const R& radii, const auto& touching,
             Memory<R>& memory, R& across, Vec3<R>& force, R& stiff, R* sums) {
    const R zero = splat<R>(0);
    const Quartets<R> grip = gather_quartets<R>(quads_.grip.data(), rows);
    const R mu = mean_of(grip_.a, grip.a), bond = mean_of(grip_.b, grip.b) * radii;
    const auto was = memory.hold < T(0);
    R gap = max(R(-memory.hold), splat<R>(loose<T>));  // that is bridged
    gap = select(pair.overlap > bond, max(gap, bond), gap);
    const auto holds = pair.overlap > -gap;
    Vec3<R> spring = select(was, memory.a, Vec3<R>{zero, zero, zero});
    R time = splat<R>(law_.damping);
    const R wet = select(touching & holds, max(grip_.c, grip.c), zero);
    if (any(wet > zero)) {
      time = damper_time(wet, grip_.d, grip.d, pair.k, law_);
      const R more = select(wet > zero, R(time - law_.damping), zero);
      sums[Sums::wet] += pair.k * more;
      sums[Sums::longest] = max(sums[Sums::longest], more);
    }
    const R pressed = select(touching & holds, contact_force(pair, time), zero);
    stiff = select(touching & (mu > zero), splat<R>(law_.tangential), zero);
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

// The sum of the stiffness of each particle's springs across [N/m].
template <class R>
inline R stiffness_of(const R* sums) {
  using Sums = PairSums<scalar_t<R>>;
  return sums[Sums::springs] + sums[Sums::springs + 1] + sums[Sums::springs + 2] + sums[Sums::shear];
}

// What the particles of a pack of mass m that move with v tell: those of the lanes `here`.
template <class R>
ParticleReport report_of(const R* sums, const R& m, const Vec3<R>& v, const ContactLaw<scalar_t<R>>& law,
                         const auto& here) {
  const R zero = splat<R>(0);
  const R v2 = select(here, dot(v, v), zero), stiffness = select(here, R(stiffness_of(sums) / m), zero);
  const R rate = select(here, rate_of(sums, m, law), zero);
  ParticleReport out;
  out.finite = !any(negated(v2 - v2 + (rate - rate) == zero));
  out.speed = std::sqrt(double(max_lane(v2)));
  out.stiffest = double(max_lane(stiffness)), out.rate = double(max_lane(rate));
  return out;
}

// How stiff the contacts and bonds of the particles that do not sleep are, and how fast these are. `sums` is overwritten.
template <class T>
ParticleReport stiffness_now(const ParticleState<T>& s, Neighbours<T>& lists, const ContactLaw<T>& law,
                             const PairQuads<T>& quads, const Groups<T>& groups, PairSums<T>& sums) {
  using R = Lanes<T>;
  if (sums.values.size() != lists.rows) sums.values.resize(lists.rows);
  return merge_each<ParticleReport>(groups.awake.size(), [&](std::size_t i) {
    const std::size_t p = groups.awake[i] * groups.lanes;
    const int count = int(detail::end_of_group(s, groups.awake[i]) - p);
    std::vector<std::uint32_t> none;
    detail::GroupForces<T>(quads, lists, law, none).template of<false>(groups.awake[i], sums.values);
    R of[PairSums<T>::count];
    for (int k = 0; k < PairSums<T>::count; ++k) of[k] = load<R>(sums.values.column(k) + p, count);
    const auto here = first_lanes<R>(count);
    const R m = select(here, load<R>(s.m.column(0) + p, count), splat<R>(1));
    const Vec3<R> x = load_vector<R>(s.x, p, count);
    ParticleReport out = report_of(of, m, load_vector<R>(s.v, p, count), law, here);
    out.finite = out.finite && !any(here & negated(dot(x, x) - dot(x, x) == splat<R>(0)));
    return out;
  });
}

}  // namespace neve
