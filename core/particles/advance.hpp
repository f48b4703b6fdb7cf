// Velocities, contact with solids, compaction and positions of the particles, from the sums over their pairs.
#pragma once

#include "mpm/model.hpp"
#include "particles/body_contacts.hpp"

namespace neve {

namespace detail {

template <class T>
class Advance {
 public:
  using R = Lanes<T>;
  using Sums = PairSums<T>;
  Advance(const ParticleModel<T>& model, const Model<T>& world, const PairSums<T>& sums, double dt)
      : model_(model), world_(world), sums_(sums), dt_(T(dt)) {}

  // Advance particles [p, p + count), or keep them in `waiting` if they may touch bodies.
  void batch(ParticleState<T>& s, std::size_t p, int count, BodyContacts<T>& waiting,
             ExchangeSum& exchange) const {
    const auto here = first_lanes<R>(count);
    const R one = splat<R>(1), zero = splat<R>(0);
    Pack pack{p,
              count,
              load_vector<R>(s.x, p, count),
              load_vector<R>(s.v, p, count),
              {zero, zero, zero},
              select(here, load<R>(s.radius.column(0) + p, count), one),
              select(here, load<R>(s.m.column(0) + p, count), one),
              {},
              waiting.contacts.size(),
              0};
    for (int k = 0; k < Sums::count; ++k)
      pack.sums[std::size_t(k)] = load<R>(sums_.values.column(k) + p, count);
    const R rate = dt_ / pack.m;
    for (int k = 0; k < 3; ++k)
      pack.v[k] += pack.sums[std::size_t(Sums::force + k)] * rate + world_.gravity[k] * dt_;
    const auto runs = here & (load<R>(s.liquid.column(0) + p, count) >= one);
    SolidContacts<R> colliders;
    for (const Solid<T>* solid : near(pack.x, pack.r, here)) {
      const auto contact = SolidContact<R>::at(*solid, pack.x, pack.r, here, runs, dt_);
      if (solid->body < 0) {
        colliders.contacts.push_back(contact);
      } else if (any(here & (contact.room * dt_ < pack.r * T(2)))) {
        waiting.contacts.push_back(contact);
      }
    }
    meet(colliders, pack, exchange);
    pack.end = waiting.contacts.size();
    if (pack.end > pack.begin) {
      waiting.packs.push_back(pack);
    } else {
      finish(s, pack);
    }
  }

  // Advance the particles that have waited, now that the bodies' velocities U are known.
  void finish_waiting(ParticleState<T>& s, BodyContacts<T>& waiting, const std::vector<Twist>& U,
                      ExchangeSum& exchange) const {
    for (Pack& pack : waiting.packs) {
      pack.v =
          touch_bodies(waiting, pack, U,
                       [&](const auto& contact, const Vec3<R>& v_co, const Vec3<R>& before,
                           const Vec3<R>& after) { note(contact, v_co, before, after, pack, exchange); });
      finish(s, pack);
    }
  }

 private:
  using Pack = typename BodyContacts<T>::Pack;

  // The solids that lanes of `here` may meet: what is within reach of the ball around them.
  std::vector<const Solid<T>*> near(const Vec3<R>& x, const R& r, const auto& here) const {
    std::vector<const Solid<T>*> out;
    if (world_.solids.empty()) return out;
    Vec3<T> low{}, high{};
    T radius = 0;
    bool first = true;
    for (int l = 0; l < width<R>; ++l) {
      if (!here[l]) continue;
      for (int k = 0; k < 3; ++k) {
        low[k] = first ? x[k][l] : std::min(low[k], x[k][l]);
        high[k] = first ? x[k][l] : std::max(high[k], x[k][l]);
      }
      radius = std::max(radius, r[l]);
      first = false;
    }
    const Vec3<T> half = (high - low) * T(0.5), middle = low + half;
    const T reach = std::sqrt(dot(half, half)) + T(4) * radius;
    for (const Solid<T>& solid : world_.solids) {
      if (is_near(solid, middle, reach)) out.push_back(&solid);
    }
    return out;
  }

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
    record(exchange.of(contact.solid->index), met, pack.m, contact.arm, v_co, before, after);
    for (int k = 0; k < 3; ++k) {
      const R force = (after[k] - before[k]) * pack.m * (T(1) / dt_);
      pack.sums[std::size_t(Sums::along + k)] += max(force, zero);
      pack.sums[std::size_t(Sums::against + k)] += max(R(-force), zero);
    }
    const Vec3<R> way = contact.way_out();
    R against = zero;  // work of setting particles out, against the forces of the others and gravity [J]
    for (int k = 0; k < 3; ++k)
      against += (pack.sums[std::size_t(Sums::force + k)] + pack.m * world_.gravity[k]) * way[k];
    exchange.of(contact.solid->index).work -= double(sum_lanes(select(met, against, zero)));
    pack.out = pack.out + way;
  }

  // Compact the particles, and move them.
  void finish(ParticleState<T>& s, Pack& pack) const {
    compact(s, pack.p, pack.count, first_lanes<R>(pack.count), pack.sums.data(), pack.r);
    store_vector(s.x, pack.p, pack.x + pack.v * dt_ + pack.out, pack.count);
    store_vector(s.v, pack.p, pack.v, pack.count);
  }

  // Compact particles that opposing forces press by more than the snow bears: in each axis as much as acts both ways
  // (Goswami, Markowicz and Hassan 2019). A particle shrinks by half of what would take the excess away, since its
  // neighbours shrink too, and never by more than what its contacts are pressed in: so none does work by shrinking.
  void compact(ParticleState<T>& s, std::size_t p, int count, const auto& here, const R* sum, R& r) const {
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
    const R force = sqrt(opposed), across = sum[Sums::across], stiffness = sum[Sums::stiffness];
    const auto yields = here & (force > bearable) & (across > T(0)) & (stiffness > T(0));
    if (!any(yields)) return;
    const R pressed =
        across / select(stiffness > T(0), stiffness, one);  // overlap, in the mean over the contacts
    const R shrink = pressed * T(0.5) * (one - bearable / select(force > T(0), force, one));
    const R smallest = r * cube_root(R(min(born * T(1 / model_.ice) / J, one)));
    const R smaller = select(yields, max(r - shrink, smallest), r);
    const R ratio = smaller / r;
    store(s.radius.column(0) + p, smaller, count);
    store(s.J_P.column(0) + p, R(J * ratio * ratio * ratio), count);
    r = smaller;
  }
  static R cube_root(R a) {
    R out = a;
    for (int l = 0; l < width<R>; ++l) out[l] = std::cbrt(a[l]);
    return out;
  }

  const ParticleModel<T>& model_;
  const Model<T>& world_;
  const PairSums<T>& sums_;
  const T dt_;
};

template <class T>
ParticleReport look(const ParticleState<T>& s, const PairSums<T>& sums, const Neighbours<T>& lists,
                    std::size_t p) {
  ParticleReport out;
  double v2 = 0, way2 = 0;
  for (int k = 0; k < 3; ++k) {
    const double v = s.v.column(k)[p], x = s.x.column(k)[p];
    const double way = x - double(lists.start.column(k)[p]) - lists.drift[k] * lists.elapsed;
    v2 += v * v, way2 += way * way;
  }
  out.speed = std::sqrt(v2), out.moved = std::sqrt(way2);
  out.stiffest = double(sums.values.column(PairSums<T>::stiffness)[p]) / double(s.m.column(0)[p]);
  out.finite = std::isfinite(v2 + way2 + out.stiffest);
  return out;
}

}  // namespace detail

// Move the particles by dt [s] with the forces in `sums`, and the gravity and the solids of `world`; `exchanged` gets, by
// solid, what snow and solids gave each other.
template <class T>
ParticleReport advance(const ParticleModel<T>& model, const Model<T>& world, ParticleState<T>& s,
                       Neighbours<T>& lists, const PairSums<T>& sums, double dt,
                       std::vector<Exchange>& exchanged) {
  using R = Lanes<T>;
  constexpr std::size_t chunk = 16 * std::size_t(width<R>);
  const detail::Advance<T> move(model, world, sums, dt);
  const std::size_t chunks = (s.count + chunk - 1) / chunk;
  std::vector<ExchangeSum> parts(chunks);
  std::vector<BodyContacts<T>> waiting(chunks);
  const auto end = [&](std::size_t c) { return std::min(s.count, (c + 1) * chunk); };
  lists.elapsed += dt;
  each_index(chunks, [&](std::size_t c) {
    for (std::size_t p = c * chunk; p < end(c); p += width<R>)
      move.batch(s, p, int(std::min<std::size_t>(width<R>, s.count - p)), waiting[c], parts[c]);
  });
  const std::vector<Twist> U = body_velocities(world.bodies, waiting, dt);
  const auto report = merge_each<ParticleReport>(chunks, [&](std::size_t c) {
    ParticleReport out;
    move.finish_waiting(s, waiting[c], U, parts[c]);
    for (std::size_t p = c * chunk; p < end(c); ++p) out.merge(detail::look(s, sums, lists, p));
    return out;
  });
  exchanged.resize(world.solids.size());
  for (const ExchangeSum& part : parts) part.add_to(exchanged);
  return report;
}

}  // namespace neve
