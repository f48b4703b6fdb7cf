// The step of the discrete element method: forces of pairs, then velocities, solids, compaction, positions.
#pragma once

#include "neighbours/gather.hpp"
#include "particles/neighbours.hpp"

namespace neve {

// The constants of one run.
template <class T>
struct ParticleModel {
  ContactLaw<T> law;
  double ice = 917;        // density at which snow is compacted no more [kg/m3]
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

// What the force of a pair needs of its particles, by rows: x, y, z [m], radius [m]; and velocity [m/s], stiffness [N/m].
template <class T>
struct PairQuads {
  Column<Quartet<T>> place, motion;

  void fill(const ParticleState<T>& s) {
    if (place.size() != s.count) place.resize(s.count), motion.resize(s.count);
    const auto at = [&](const auto& field, int k) { return field.column(k); };
    const T *x = at(s.x, 0), *y = at(s.x, 1), *z = at(s.x, 2), *r = at(s.radius, 0);
    const T *u = at(s.v, 0), *v = at(s.v, 1), *w = at(s.v, 2), *stiffness = at(s.k, 0);
    each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        place[p] = {x[p], y[p], z[p], r[p]};
        motion[p] = {u[p], v[p], w[p], stiffness[p]};
      }
    });
  }
};

// What a pass over the particles found.
struct ParticleReport {
  double speed = 0;     // largest [m/s]
  double stiffest = 0;  // largest sum of the stiffness of a particle's contacts over its mass [1/s2]
  double moved = 0;     // longest way against the drift since the lists were made [m]
  bool finite = true;
  void merge(const ParticleReport& o) {
    speed = std::max(speed, o.speed), stiffest = std::max(stiffest, o.stiffest),
    moved = std::max(moved, o.moved);
    finite = finite && o.finite;
  }
};

namespace detail {

// The lanes of one particle's neighbours from entry e on, and the sums over them.
template <class T>
class ParticleForces {
 public:
  using R = Lanes<T>;
  ParticleForces(const ParticleState<T>& s, const PairQuads<T>& quads, Neighbours<T>& lists,
                 const ContactLaw<T>& law)
      : s_(s), quads_(quads), lists_(lists), law_(law) {}

  void of(std::size_t p, T* out, std::size_t stride) {
    R sums[PairSums<T>::count]{};
    for (std::uint32_t e = lists_.begin[p]; e < lists_.begin[p + 1]; e += width<R>)
      add(p, e, int(std::min<std::uint32_t>(width<R>, lists_.begin[p + 1] - e)), sums);
    for (int k = 0; k < PairSums<T>::count; ++k) out[std::size_t(k) * stride] = sum_lanes(sums[k]);
  }

 private:
  void add(std::size_t p, std::uint32_t e, int count, R* sums) {
    const std::int32_t* rows = lists_.row.data() + e;
    const auto here = first_lanes<R>(count);
    const Quartets<R> place = gather_quartets<R>(quads_.place.data(), rows);
    const Quartet<T> place_p = quads_.place[p];
    const Vec3<R> x{place_p.a - place.a, place_p.b - place.b, place_p.c - place.c};
    const R radii = place_p.d + place.d;
    Pair<R> pair = pair_at(x, radii);
    const R zero = splat<R>(0);
    R hold = load<R>(lists_.hold.data() + e, count);
    if (!any(here & ((pair.overlap > T(0)) | negated(hold == T(0))))) return;
    const Quartets<R> motion = gather_quartets<R>(quads_.motion.data(), rows);
    const Quartet<T> motion_p = quads_.motion[p];
    const Vec3<R> v{motion_p.a - motion.a, motion_p.b - motion.b, motion_p.c - motion.c};
    const R k = (motion_p.d + motion.d) * T(0.5);
    set_motion(pair, v, k);
    const R rest = load<R>(lists_.a.data() + e, count);
    auto bonded = here & (hold > T(0));
    const auto broken = bonded & (rest - pair.overlap > hold);
    if (any(broken)) {
      hold = select(broken, zero, hold);
      store(lists_.hold.data() + e, hold, count);
      bonded = bonded & (hold > T(0));
    }
    R across = select(bonded, bond_force(pair, rest, law_), zero);
    Vec3<R> force = pair.n * across;
    const auto touching = here & negated(bonded) & ((pair.overlap > T(0)) | (hold < T(0)));
    auto active = bonded | touching;
    if (any(touching)) {
      Memory<R> memory{hold,
                       {rest, load<R>(lists_.b.data() + e, count), load<R>(lists_.c.data() + e, count)}};
      active = bonded | (touching & touch(p, rows, pair, radii, touching, memory, across, force));
      store(lists_.hold.data() + e, memory.hold, count);
      store(lists_.a.data() + e, memory.a.x, count);
      store(lists_.b.data() + e, memory.a.y, count);
      store(lists_.c.data() + e, memory.a.z, count);
    }
    for (int i = 0; i < 3; ++i) {
      const R normal = pair.n[i] * across;
      sums[PairSums<T>::force + i] += force[i];
      sums[PairSums<T>::along + i] += max(normal, zero);
      sums[PairSums<T>::against + i] += max(R(-normal), zero);
    }
    sums[PairSums<T>::across] += across;
    sums[PairSums<T>::stiffness] += select(active, k, zero);
  }

  // The contacts among the lanes `touching`: their forces join `across` and `force`. Returns which of them hold on.
  auto touch(std::size_t p, const std::int32_t* rows, const Pair<R>& pair, const R& radii,
             const auto& touching, Memory<R>& memory, R& across, Vec3<R>& force) {
    const R zero = splat<R>(0);
    const R mu_q = gather<R>(s_.mu.column(0), rows), bond_q = gather<R>(s_.bond.column(0), rows);
    const R mu = mean_of(s_.mu.column(0)[p], mu_q), bond = mean_of(s_.bond.column(0)[p], bond_q) * radii;
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
  static R mean_of(T a, const R& b) {
    const R zero = splat<R>(0);
    return a > T(0) ? select(b > zero, R((b + a) * T(0.5)), zero) : zero;
  }

  const ParticleState<T>& s_;
  const PairQuads<T>& quads_;
  Neighbours<T>& lists_;
  const ContactLaw<T> law_;
};

}  // namespace detail

// Sum the forces between particles; contacts are made and broken. Each pair is computed from both its sides, with forces
// that are opposite to the last bit.
template <class T>
void pair_forces(const ParticleState<T>& s, Neighbours<T>& lists, const ContactLaw<T>& law,
                 PairQuads<T>& quads, PairSums<T>& sums) {
  if (sums.values.size() != s.count) sums.values.resize(s.count);
  quads.fill(s);
  constexpr std::size_t chunk = 256;
  each_index((s.count + chunk - 1) / chunk, [&](std::size_t c) {
    detail::ParticleForces<T> forces(s, quads, lists, law);
    for (std::size_t p = c * chunk; p < std::min(s.count, (c + 1) * chunk); ++p)
      forces.of(p, sums.values.column(0) + p, sums.values.stride());
  });
}

// How stiff the contacts and bonds of the particles are, and how fast they are.
template <class T>
ParticleReport stiffness_of(const ParticleState<T>& s, const Neighbours<T>& lists) {
  constexpr std::size_t chunk = 256;
  const T *x = s.x.column(0), *y = s.x.column(1), *z = s.x.column(2), *r = s.radius.column(0);
  return merge_each<ParticleReport>((s.count + chunk - 1) / chunk, [&](std::size_t c) {
    ParticleReport out;
    for (std::size_t p = c * chunk; p < std::min(s.count, (c + 1) * chunk); ++p) {
      double sum = 0, v2 = 0;
      for (std::uint32_t e = lists.begin[p]; e < lists.begin[p + 1]; ++e) {
        const auto q = std::size_t(lists.row[e]);
        const T dx = x[p] - x[q], dy = y[p] - y[q], dz = z[p] - z[q], radii = r[p] + r[q];
        if (lists.hold[e] != T(0) || dx * dx + dy * dy + dz * dz < radii * radii)
          sum += 0.5 * (double(s.k.column(0)[p]) + double(s.k.column(0)[q]));
      }
      for (int k = 0; k < 3; ++k) v2 += double(s.v.column(k)[p]) * double(s.v.column(k)[p]);
      out.stiffest = std::max(out.stiffest, sum / double(s.m.column(0)[p]));
      out.speed = std::max(out.speed, std::sqrt(v2));
      out.finite = out.finite && std::isfinite(sum + v2) && std::isfinite(x[p] + y[p] + z[p]);
    }
    return out;
  });
}

}  // namespace neve
