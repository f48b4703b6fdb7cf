// Sums over all particles and their contacts, and a packing for them to begin with.
#pragma once

#include "particles/step.hpp"

namespace neve {

struct ParticleTotals {
  double mass = 0, momentum[3] = {0, 0, 0}, kinetic = 0, potential = 0;
  double elastic = 0;  // of bonds, contacts and their friction [J]
  double bonds = 0, contacts = 0;
  void add(const ParticleTotals& o) {
    mass += o.mass, kinetic += o.kinetic, potential += o.potential, elastic += o.elastic;
    bonds += o.bonds, contacts += o.contacts;
    for (int k = 0; k < 3; ++k) momentum[k] += o.momentum[k];
  }
};

namespace detail {

// Half of what a pair stores [J], seen from one side.
template <class T>
double stored(const ParticleState<T>& s, const Neighbours<T>& lists, const ContactLaw<T>& law, std::size_t p,
              std::uint32_t e) {
  const auto q = std::size_t(lists.row[e]);
  double d2 = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = double(s.x.column(k)[p]) - double(s.x.column(k)[q]);
    d2 += d * d;
  }
  const double overlap = double(s.radius.column(0)[p]) + double(s.radius.column(0)[q]) - std::sqrt(d2);
  const double k = 0.5 * (double(s.k.column(0)[p]) + double(s.k.column(0)[q]));
  const double a = lists.a[e], b = lists.b[e], c = lists.c[e];
  if (lists.hold[e] > T(0)) return 0.25 * k * (overlap - a) * (overlap - a);
  const double rubbed = lists.hold[e] < T(0) ? double(law.tangential) * (a * a + b * b + c * c) : 0.0;
  return 0.25 * k * ((lists.hold[e] < T(0) || overlap > 0 ? overlap * overlap : 0.0) + rubbed);
}

}  // namespace detail

// Sum in double, in chunks merged in order: the same bits for any number of threads.
template <class T>
ParticleTotals totals(const ParticleModel<T>& model, const ParticleState<T>& s, const Neighbours<T>& lists) {
  constexpr std::size_t chunk = 1024;
  std::vector<ParticleTotals> parts((s.count + chunk - 1) / chunk);
  each_index(parts.size(), [&](std::size_t part) {
    ParticleTotals& sum = parts[part];
    for (std::size_t p = part * chunk; p < std::min(s.count, (part + 1) * chunk); ++p) {
      const double m = s.m.column(0)[p];
      sum.mass += m;
      for (int k = 0; k < 3; ++k) {
        const double v = s.v.column(k)[p];
        sum.momentum[k] += m * v;
        sum.kinetic += 0.5 * m * v * v;
        sum.potential -= m * double(model.gravity[k]) * double(s.x.column(k)[p]);
      }
      for (std::uint32_t e = lists.begin[p]; e < lists.begin[p + 1]; ++e) {
        sum.elastic += detail::stored(s, lists, model.law, p, e);
        sum.bonds += 0.5 * (lists.hold[e] > T(0));
        sum.contacts += 0.5 * (lists.hold[e] < T(0));
      }
    }
  });
  ParticleTotals total;
  for (const ParticleTotals& part : parts) total.add(part);
  return total;
}

// Move particles that overlap apart: each by half of the mean of its overlaps, as often as asked. Returns the largest
// overlap that is left, over the sum of the radii.
template <class T>
double relax(ParticleState<T>& s, Neighbours<T>& lists) {
  Field<T, 3> moved;
  moved.resize(s.count);
  std::vector<double> worst(std::size_t(thread_count()), 0.0);
  each_chunk(s.count, [&](int chunk, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      T push[3] = {0, 0, 0};
      int pairs = 0;
      for (std::uint32_t e = lists.begin[p]; e < lists.begin[p + 1]; ++e) {
        const auto q = std::size_t(lists.row[e]);
        T d[3], d2 = 0;
        for (int k = 0; k < 3; ++k) d[k] = s.x.column(k)[p] - s.x.column(k)[q], d2 += d[k] * d[k];
        const T radii = s.radius.column(0)[p] + s.radius.column(0)[q], far = std::sqrt(d2);
        if (far >= radii || far == T(0)) continue;
        worst[std::size_t(chunk)] = std::max(worst[std::size_t(chunk)], double((radii - far) / radii));
        for (int k = 0; k < 3; ++k) push[k] += d[k] / far * (radii - far) * T(0.5);
        ++pairs;
      }
      for (int k = 0; k < 3; ++k) moved.column(k)[p] = pairs ? push[k] / std::sqrt(T(pairs)) : T(0);
    }
  });
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (int k = 0; k < 3; ++k) {
      for (std::size_t p = begin; p < end; ++p) s.x.column(k)[p] += moved.column(k)[p];
    }
  });
  return *std::max_element(worst.begin(), worst.end());
}

}  // namespace neve
