// Velocities, contact with solids, compaction and positions of the particles, from the sums over their pairs.
#pragma once

#include "mpm/model.hpp"
#include "particles/body_contacts.hpp"
#include "particles/step.hpp"

namespace neve {

// What a step has to tell of particles: who leaves the place where its neighbours were listed, and who wakes and falls asleep.
struct StepEvents {
  struct Firmer {
    std::int32_t row;
    double before;  // its strength_of
    bool operator<(const Firmer& o) const { return row < o.row; }
  };
  std::vector<std::int32_t> moved;  // rows
  std::vector<std::uint32_t> wakes,
      calm;                    // groups: sleepers that are pushed; what has rested for long enough
  std::vector<Firmer> firmer;  // what compaction has made stronger
  bool any() const { return !moved.empty() || !wakes.empty() || !calm.empty() || !firmer.empty(); }
  void clear() { moved.clear(), wakes.clear(), calm.clear(), firmer.clear(); }
  void add(const StepEvents& o) {
    moved.insert(moved.end(), o.moved.begin(), o.moved.end());
    wakes.insert(wakes.end(), o.wakes.begin(), o.wakes.end());
    calm.insert(calm.end(), o.calm.begin(), o.calm.end());
    firmer.insert(firmer.end(), o.firmer.begin(), o.firmer.end());
  }
};

namespace detail {

// Particles that may touch bodies, with the sums over their pairs.
template <class T>
struct ParticlePack : ContactPack<T> {
  std::array<Lanes<T>, PairSums<T>::count> sums;
};

// What one chunk of groups found in a step.
template <class T>
struct ChunkResult {
  ParticleReport report;
  StepEvents events;
  ExchangeSum exchange;
  BodyContacts<T, ParticlePack<T>> waiting;
  SolidContacts<Lanes<T>> colliders;  // memory that is used again

  void clear() {
    report = {};
    events.clear(), exchange.clear(), waiting.packs.clear(), waiting.contacts.clear();
  }
};

template <class T>
class Advance {
 public:
  using R = Lanes<T>;
  using Sums = PairSums<T>;
  Advance(const ParticleModel<T>& model, const std::vector<ContactMaterial>& table, const Model<T>& world,
          const Listing<T>& listing, PairQuads<T>& quads, bool any_asleep, const PairSums<T>& sums, double dt)
      : model_(model),
        table_(table),
        world_(world),
        listing_(listing),
        quads_(quads),
        any_asleep_(any_asleep),
        sums_(sums),
        shift_(listing.shift()),
        dt_(T(dt)) {}

  // Advance particles [p, p + count), or keep them in `waiting` if they may touch bodies.
  void batch(ParticleState<T>& s, std::size_t p, int count, ChunkResult<T>& out) const {
    auto& waiting = out.waiting;
    const auto here = first_lanes<R>(count);
    const R one = splat<R>(1), zero = splat<R>(0);
    Pack pack{{p,
               count,
               load_vector<R>(s.x, p, count),
               load_vector<R>(s.v, p, count),
               {zero, zero, zero},
               select(here, load<R>(s.radius.column(0) + p, count), one),
               select(here, load<R>(s.m.column(0) + p, count), one),
               waiting.contacts.size(),
               0},
              {}};
    for (int k = 0; k < Sums::count; ++k)
      pack.sums[std::size_t(k)] = load<R>(sums_.values.column(k) + p, count);
    const R rate = dt_ / pack.m;
    for (int k = 0; k < 3; ++k)
      pack.v[k] += pack.sums[std::size_t(Sums::force + k)] * rate + world_.gravity[k] * dt_;
    const auto runs = here & (load<R>(s.liquid.column(0) + p, count) >= one);
    Around<T> ball = ball_around(pack.x, here);  // within which they may meet a solid
    ball.radius += T(4) * largest_lane(select(here, pack.r, zero));
    SolidContacts<R>& colliders = out.colliders;
    colliders.contacts.clear();
    for (const Solid<T>& solid : world_.solids) {
      if (!is_near(solid, ball.middle, ball.radius)) continue;
      const auto contact = SolidContact<R>::at(solid, pack.x, pack.r, pack.r, here, runs, dt_);
      if (solid.body < 0) {
        colliders.contacts.push_back(contact);
      } else if (any(here & (contact.room * dt_ < pack.r * T(2)))) {
        waiting.contacts.push_back(contact);
      }
    }
    meet(colliders, pack, out.exchange);
    pack.end = waiting.contacts.size();
    if (pack.end > pack.begin) {
      waiting.packs.push_back(pack);
    } else {
      finish(s, pack, out);
    }
  }

  // Advance the particles that have waited, now that the bodies' velocities U are known.
  void finish_waiting(ParticleState<T>& s, const std::vector<Twist>& U, ChunkResult<T>& out) const {
    for (Pack& pack : out.waiting.packs) {
      pack.v =
          touch_bodies(out.waiting, pack, U,
                       [&](const auto& contact, const Vec3<R>& v_co, const Vec3<R>& before,
                           const Vec3<R>& after) { note(contact, v_co, before, after, pack, out.exchange); });
      finish(s, pack, out);
    }
  }

 private:
  using Pack = ParticlePack<T>;

  // Let the colliders act.
  void meet(SolidContacts<R>& colliders, Pack& pack, ExchangeSum& exchange) const {
    pack.v = colliders.act(pack.v, dt_);
    for (std::size_t e = 0; e < colliders.contacts.size(); ++e) {
      const ContactChange<R>& change = colliders.changes[e];
      note(colliders.contacts[e], change.v_co, change.before, change.after, pack, exchange);
    }
  }

  // Record what a solid did, and let its forces count in compaction.
  void note(const SolidContact<R>& contact, const Vec3<R>& v_co, const Vec3<R>& before, const Vec3<R>& after,
            Pack& pack, ExchangeSum& exchange) const {
    const R zero = splat<R>(0);
    const auto met = contact.met(before, v_co);
    if (!any(met)) return;
    Vec3<R> of_others;
    for (int k = 0; k < 3; ++k) {
      of_others[k] = pack.sums[std::size_t(Sums::force + k)] + pack.m * world_.gravity[k];
      const R force = (after[k] - before[k]) * pack.m * (T(1) / dt_);
      pack.sums[std::size_t(Sums::along + k)] += max(force, zero);
      pack.sums[std::size_t(Sums::against + k)] += max(R(-force), zero);
    }
    pack.out = pack.out + record_contact(contact, met, pack.m, v_co, before, after, of_others, exchange);
  }

  // Compact the particles, move them, and see what becomes of them.
  void finish(ParticleState<T>& s, Pack& pack, ChunkResult<T>& out) const {
    const std::size_t p = pack.p;
    const int count = pack.count;
    compact(s, p, count, first_lanes<R>(count), pack.sums.data(), pack.r, out.events.firmer);
    const Vec3<R> x = pack.x + pack.v * dt_ + pack.out;
    store_vector(s.x, p, x, count);
    store_vector(s.v, p, pack.v, count);
    report(x, pack, out);
    if (model_.sleep.way > 0) rest(s, x, pack, out);
    for (std::size_t q = p; q < p + std::size_t(count); ++q) quads_.set(s, q, false);
  }

  void report(const Vec3<R>& x, const Pack& pack, ChunkResult<T>& out) const {
    const R zero = splat<R>(0);
    const auto here = first_lanes<R>(pack.count);
    std::int32_t rows[width<R>];
    for (int l = 0; l < width<R>; ++l) rows[l] = std::int32_t(pack.p) + std::min(l, pack.count - 1);
    const Quartets<R> start = gather_quartets<R>(listing_.grid.starts(), rows);
    const Vec3<R> way = x - spread<R>(shift_) - Vec3<R>{start.a, start.b, start.c};
    const R way2 = select(here, dot(way, way), zero);
    ParticleReport mine = report_of(pack.sums.data(), pack.m, pack.v, model_.law, here);
    mine.finite = mine.finite && !any(negated(way2 - way2 == T(0)));
    out.report.merge(mine);
    const auto leaves = here & negated(way2 <= start.d * start.d);
    if (!any(leaves)) return;
    for (int l = 0; l < pack.count; ++l) {
      if (leaves[l]) out.events.moved.push_back(rows[l]);
    }
  }

  // How long the particles have stayed near a place. One that gets away from it twice as fast as what rests may wakes the sleepers
  // that it is in contact with.
  void rest(ParticleState<T>& s, const Vec3<R>& x, const Pack& pack, ChunkResult<T>& out) const {
    const SleepRule& rule = model_.sleep;
    const auto here = first_lanes<R>(pack.count);
    const Vec3<R> place = load_vector<R>(s.rest, pack.p, pack.count, 1), way = x - place;
    const auto gone = here & negated(dot(way, way) <= T(rule.way * rule.way));
    const R time = load<R>(s.rest.column(0) + pack.p, pack.count) + dt_;
    const R rested = select(gone, splat<R>(0), time);
    store(s.rest.column(0) + pack.p, rested, pack.count);
    const auto fast = gone & (time < T(0.5 * rule.after));
    if (any(gone)) store_vector(s.rest, pack.p, select(gone, x, place), pack.count, 1);
    if (any_asleep_ && any(fast)) {
      for (int l = 0; l < pack.count; ++l) {
        if (fast[l]) push(pack.p + std::size_t(l), out.events.wakes);
      }
    }
    if (!rule.may_sleep) return;
    const auto rests = here & (rested >= T(rule.after));
    const T calm = sum_lanes(select(rests, splat<R>(1), splat<R>(0)));
    if (calm >= T(rule.share * pack.count)) out.events.calm.push_back(std::uint32_t(pack.p / group_rows<T>));
  }
  void push(std::size_t p, std::vector<std::uint32_t>& wakes) const {
    const Neighbours<T>& lists = listing_.lists;
    lists.each(p, [&](std::uint32_t e) {
      const auto q = std::size_t(lists.row[e]);
      if (lists.hold[e] != T(0) && quads_.asleep(q)) wakes.push_back(std::uint32_t(q / group_rows<T>));
    });
  }

  // Compact particles that opposing forces press by more than the snow bears: in each axis as much as acts both ways
  // (Goswami, Markowicz and Hassan 2019). A particle shrinks by half of what would take the excess away, since its
  // neighbours shrink too, and never by more than what its contacts are pressed in: so none does work by shrinking.
  void compact(ParticleState<T>& s, std::size_t p, int count, const auto& here, const R* sum, R& r,
               std::vector<StepEvents::Firmer>& firmer) const {
    const R zero = splat<R>(0), one = splat<R>(1);
    R opposed = zero;
    for (int k = 0; k < 3; ++k) {
      const R both = min(sum[Sums::along + k], sum[Sums::against + k]);
      opposed += both * both;
    }
    const R m = load<R>(s.m.column(0) + p, count), V0 = select(here, load<R>(s.V0.column(0) + p, count), one);
    const R J = select(here, load<R>(s.J_P.column(0) + p, count), one);
    const R born = m / V0;
    const R yield = load<R>(s.yield.column(0) + p, count);
    const R risen = (born / J - born) * T(1 / model_.hardening);
    const R bearable = yield * exp(min(risen, splat<R>(80))) * r * r * T(3.14159265358979);
    const R force = sqrt(opposed), across = sum[Sums::across], stiffness = stiffness_of(sum);
    const auto yields = here & (force > bearable) & (across > T(0)) & (stiffness > T(0));
    if (!any(yields)) return;
    const R pressed =
        across / select(stiffness > T(0), stiffness, one);  // overlap, in the mean over the contacts
    const R shrink = pressed * T(0.5) * (one - bearable / select(force > T(0), force, one));
    const R smallest = r * cube_root(R(min(born * T(1 / model_.ice) / J, one)));
    const R smaller = select(yields, max(r - shrink, smallest), r);
    const R ratio = smaller / r;
    std::array<double, width<R>> before{};
    for (int l = 0; l < count; ++l)
      before[std::size_t(l)] = yields[l] ? strength_of(s, table_, p + std::size_t(l)) : 0.0;
    store(s.radius.column(0) + p, smaller, count);
    store(s.J_P.column(0) + p, R(J * ratio * ratio * ratio), count);
    r = smaller;
    for (int l = 0; l < count; ++l) {
      if (yields[l]) strengthen(s, p + std::size_t(l), before[std::size_t(l)], firmer);
    }
  }
  // Let a particle that has been compacted bear more than `before`.
  void strengthen(ParticleState<T>& s, std::size_t p, double before,
                  std::vector<StepEvents::Firmer>& firmer) const {
    derive(s, table_, p);
    if (strength_of(s, table_, p) != before) firmer.push_back({std::int32_t(p), before});
  }
  static R cube_root(R a) {
    R out = a;
    for (int l = 0; l < width<R>; ++l) out[l] = std::cbrt(a[l]);
    return out;
  }

  const ParticleModel<T>& model_;
  const std::vector<ContactMaterial>& table_;
  const Model<T>& world_;
  const Listing<T>& listing_;
  PairQuads<T>& quads_;
  const bool any_asleep_;
  const PairSums<T>& sums_;
  const Vec3<T> shift_;
  const T dt_;
};

}  // namespace detail

// Move the particles that do not sleep by dt [s] with the forces in `sums`, and the gravity and the solids of `world`;
// `exchanged` gets, by solid, what snow and solids gave each other, and `events` what there is to do. `parts`: memory that is used
// again.
template <class T>
ParticleReport advance(const ParticleModel<T>& model, const std::vector<ContactMaterial>& table,
                       const Model<T>& world, ParticleState<T>& s, Listing<T>& listing, PairQuads<T>& quads,
                       const Groups<T>& groups, const PairSums<T>& sums, double dt,
                       std::vector<Exchange>& exchanged, StepEvents& events,
                       std::vector<detail::ChunkResult<T>>& parts) {
  constexpr std::size_t chunk = 8;
  listing.elapsed += dt;
  const detail::Advance<T> move(model, table, world, listing, quads, groups.sleepers > 0, sums, dt);
  const std::vector<std::uint32_t>& awake = groups.awake;
  parts.resize((awake.size() + chunk - 1) / chunk);
  each_index(parts.size(), [&](std::size_t c) {
    parts[c].clear();
    for (std::size_t i = c * chunk; i < std::min(awake.size(), (c + 1) * chunk); ++i) {
      const std::size_t p = awake[i] * groups.lanes;
      move.batch(s, p, int(std::min(groups.lanes, s.count - p)), parts[c]);
    }
  });
  std::vector<const BodyContacts<T, detail::ParticlePack<T>>*> waiting;
  for (const auto& part : parts) waiting.push_back(&part.waiting);
  const std::vector<Twist> U = body_velocities(world.bodies, waiting, dt);
  if (!U.empty()) each_index(parts.size(), [&](std::size_t c) { move.finish_waiting(s, U, parts[c]); });
  ParticleReport report;
  exchanged.resize(world.solids.size());
  for (const auto& part : parts) {
    report.merge(part.report), events.add(part.events), part.exchange.add_to(exchanged);
  }
  return report;
}

}  // namespace neve
