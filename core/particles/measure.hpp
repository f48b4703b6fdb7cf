// Sums over all particles and their contacts.
#pragma once

#include "heat/enthalpy.hpp"
#include "particles/step.hpp"

namespace neve {

struct ParticleTotals {
  double mass = 0, momentum[3] = {0, 0, 0}, kinetic = 0, potential = 0;
  double elastic = 0;  // of bonds, contacts and their friction [J]
  double bonds = 0, contacts = 0;
  double heat = 0, water = 0;  // enthalpy [J], liquid mass [kg]
  void add(const ParticleTotals& o) {
    mass += o.mass, kinetic += o.kinetic, potential += o.potential, elastic += o.elastic;
    bonds += o.bonds, contacts += o.contacts, heat += o.heat, water += o.water;
    for (int k = 0; k < 3; ++k) momentum[k] += o.momentum[k];
  }
};

namespace detail {

// Half of what a pair stores [J], seen from one side. A bond or a contact that is stretched too far stores nothing: it
// breaks before it pulls.
template <class T>
double stored(const ParticleState<T>& s, const Neighbours<T>& lists, const ContactLaw<T>& law, std::size_t p,
              std::uint32_t e) {
  const auto q = std::size_t(lists.row[e]);
  const double overlap = double(s.radius.column(0)[p]) + double(s.radius.column(0)[q]) - distance(s, p, q);
  const double k = 0.5 * (double(s.k.column(0)[p]) + double(s.k.column(0)[q]));
  const double a = lists.a[e], b = lists.b[e], c = lists.c[e];
  const double hold = lists.hold[e];
  if (hold > 0) return a - overlap > hold ? 0.0 : 0.25 * k * (overlap - a) * (overlap - a);
  if (overlap <= hold) return 0.0;  // the gap that a contact bridges is -hold
  const double rubbed = hold < 0 ? double(law.tangential) * (a * a + b * b + c * c) : 0.0;
  return 0.25 * k * (overlap * overlap + rubbed);
}

// Add what particle p has by itself to `sum`.
template <class T>
void add_particle(const ParticleState<T>& s, const Vec3<T>& gravity, std::size_t p, ParticleTotals& sum) {
  const double m = s.m.column(0)[p];
  sum.mass += m, sum.heat += s.enthalpy[p], sum.water += m * heat::liquid(s.enthalpy[p], m);
  for (int k = 0; k < 3; ++k) {
    const double v = s.v.column(k)[p];
    sum.momentum[k] += m * v;
    sum.kinetic += 0.5 * m * v * v;
    sum.potential -= m * double(gravity[k]) * double(s.x.column(k)[p]);
  }
}

}  // namespace detail

// Sum in double, in chunks merged in order: the same bits for any number of threads.
template <class T>
ParticleTotals totals(const ContactLaw<T>& law, const Vec3<T>& gravity, const ParticleState<T>& s,
                      const Neighbours<T>& lists) {
  constexpr std::size_t chunk = 1024;
  std::vector<ParticleTotals> parts((s.count + chunk - 1) / chunk);
  each_index(parts.size(), [&](std::size_t part) {
    ParticleTotals& sum = parts[part];
    for (std::size_t p = part * chunk; p < std::min(s.count, (part + 1) * chunk); ++p) {
      detail::add_particle(s, gravity, p, sum);
      lists.each(p, [&](std::uint32_t e) {
        sum.elastic += detail::stored(s, lists, law, p, e);
        sum.bonds += 0.5 * (lists.hold[e] > T(0));
        sum.contacts += 0.5 * (lists.hold[e] < T(0));
      });
    }
  });
  ParticleTotals total;
  for (const ParticleTotals& part : parts) total.add(part);
  return total;
}

// What is lost with the particles at `rows`, in this order: what they have, and what their pairs store with each other and with the
// others. Pairs that are not listed store nothing.
template <class T>
ParticleTotals totals_of(const ContactLaw<T>& law, const Vec3<T>& gravity, const ParticleState<T>& s,
                         const Neighbours<T>& lists, const std::vector<std::uint32_t>& rows) {
  std::vector<char> among(s.count, 0);
  for (const std::uint32_t p : rows) among[p] = 1;
  ParticleTotals sum;
  for (const std::uint32_t p : rows) {
    detail::add_particle(s, gravity, p, sum);
    if (lists.rows != s.count) continue;
    lists.each(p, [&](std::uint32_t e) {
      const double share = among[std::size_t(lists.row[e])] ? 1 : 2;  // of the half seen from p
      sum.elastic += share * detail::stored(s, lists, law, p, e);
      sum.bonds += 0.5 * share * (lists.hold[e] > T(0));
      sum.contacts += 0.5 * share * (lists.hold[e] < T(0));
    });
  }
  return sum;
}

}  // namespace neve
