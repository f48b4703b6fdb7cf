// Velocities, contact with solids, compaction and positions of the particles, from the sums over their pairs.
#pragma once

#include "coupling/exchange.hpp"
#include "cpu/fields.hpp"
#include "mpm/model.hpp"
#include "particles/step.hpp"

namespace neve {

namespace detail {

// How fast a particle that lies inside a solid is set out of it: the share of the depth per step.
inline constexpr double set_out = 0.1;

template <class T>
class Advance {
 public:
  using R = Lanes<T>;
  using Sums = PairSums<T>;
  Advance(const ParticleModel<T>& model, const Model<T>& world, const PairSums<T>& sums, double dt)
      : model_(model), world_(world), sums_(sums), dt_(T(dt)) {}

  // Advance particles [p, p + count).
  void batch(ParticleState<T>& s, std::size_t p, int count, ExchangeSum& exchange) const {
    const auto here = first_lanes<R>(count);
    const R one = splat<R>(1), zero = splat<R>(0);
    R sum[Sums::count];
    for (int k = 0; k < Sums::count; ++k) sum[k] = load<R>(sums_.values.column(k) + p, count);
    const R m = select(here, load<R>(s.m.column(0) + p, count), one);
    R r = select(here, load<R>(s.radius.column(0) + p, count), one);
    Vec3<R> x = load_vector<R>(s.x, p, count), v = load_vector<R>(s.v, p, count);
    const R rate = dt_ / m;
    for (int k = 0; k < 3; ++k) v[k] += sum[Sums::force + k] * rate + world_.gravity[k] * dt_;
    Vec3<R> out{zero, zero, zero};
    for (const Solid<T>& solid : near(x, r, here)) meet(solid, x, r, m, here, v, out, sum, exchange);
    compact(s, p, count, here, sum, r);
    x = x + v * dt_ + out;
    store_vector(s.x, p, x, count);
    store_vector(s.v, p, v, count);
  }

 private:
  // The solids that lanes of `here` may meet: what is within reach of the ball around them.
  std::vector<Solid<T>> near(const Vec3<R>& x, const R& r, const auto& here) const {
    std::vector<Solid<T>> out;
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
      if (is_near(solid, middle, reach)) out.push_back(solid);
    }
    return out;
  }

  // Contact with one solid (docs/particles.md): a particle that would sink in moves to its surface in this step, with
  // the laws of contact of the material point method; one that lies inside is set out, without a velocity.
  void meet(const Solid<T>& solid, const Vec3<R>& x, const R& r, const R& m, const auto& here, Vec3<R>& v,
            Vec3<R>& out, R* sum, ExchangeSum& exchange) const {
    const R zero = splat<R>(0);
    const Surface<R> surface = neve::surface(solid, x);
    const R gap = surface.phi - r, room = max(gap, zero) * (T(1) / dt_);
    const Vec3<R> n = surface.normal, v_co = solid.surface_velocity_at(x, n);
    const Vec3<R> sped = v + n * room;  // of zero along n: it just arrives
    const auto held = gap <= T(0), met = here & ((dot(sped - v_co, n) < T(0)) | held);
    if (!any(met)) return;
    constexpr ContactMode leaves = ContactMode::separate;
    const R dt = splat<R>(dt_);
    const Vec3<R> arrives =
        after_contact(sped, facing(solid, x, n, Vec3<R>(sped - v_co), dt), v_co, leaves, solid.mu_c);
    const Vec3<R> holds = after_contact(v, facing(solid, x, n, Vec3<R>(v - v_co), dt), v_co,
                                        has_play(solid.mode, solid.mu_c) ? leaves : solid.mode, solid.mu_c);
    const Vec3<R> after = select(met, select(held, holds, arrives - n * room), v);
    record(exchange.of(solid.index), met, m, x - spread<R>(solid.centre), v_co, v, after);
    for (int k = 0; k < 3; ++k) {
      const R force = (after[k] - v[k]) * m * (T(1) / dt_);
      sum[Sums::along + k] += max(force, zero);
      sum[Sums::against + k] += max(R(-force), zero);
    }
    v = after;
    out = out + n * select(here, max(R(-gap), zero) * T(set_out), zero);
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
  lists.elapsed += dt;
  const auto report = merge_each<ParticleReport>(chunks, [&](std::size_t c) {
    ParticleReport out;
    for (std::size_t p = c * chunk; p < std::min(s.count, (c + 1) * chunk); p += width<R>) {
      const int count = int(std::min<std::size_t>(width<R>, s.count - p));
      move.batch(s, p, count, parts[c]);
      for (int l = 0; l < count; ++l) out.merge(detail::look(s, sums, lists, p + std::size_t(l)));
    }
    return out;
  });
  exchanged.resize(world.solids.size());
  for (const ExchangeSum& part : parts) part.add_to(exchanged);
  return report;
}

}  // namespace neve
