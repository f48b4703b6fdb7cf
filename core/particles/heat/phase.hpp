// What heat makes of particles and their bonds: melting, freezing, sintering.
#pragma once

#include "heat/sintering.hpp"
#include "particles/heat/conduction.hpp"

namespace neve {

namespace detail {

// A pass over phases and bonds after heat has flowed.
template <class T>
class PhaseChange {
 public:
  PhaseChange(const HeatModel& model, ParticleState<T>& s, Neighbours<T>& lists)
      : model_(model),
        s_(s),
        lists_(lists),
        grown_(s.count),
        strain_(s.count),
        freezes_(s.count),
        changed_(s.count),
        strain_before_(s.count),
        k_before_(s.k.column(0), s.k.column(0) + s.count) {}

  // `derive`: called for a particle whose liquid share has changed. dt: of the heat's own time [s]. Returns which have.
  template <class F>
  std::vector<char> apply(double dt, F&& derive) {
    each_chunk(s_.count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        strain_before_[p] = strain(p);
        changed_[p] = change(p);
        if (changed_[p]) derive(p);
        strain_[p] = changed_[p] ? strain(p) : strain_before_[p];
      }
    });
    each_chunk(s_.count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        lists_.each(p, [&](std::uint32_t e) { pair(p, e, dt); });
      }
    });
    return std::move(changed_);
  }

 private:
  // Take over the liquid share of the enthalpy, once it differs enough.
  bool change(std::size_t p) {
    const double m = s_.m.column(0)[p], f = s_.liquid.column(0)[p];
    const double now = heat::liquid(s_.enthalpy[p], m);
    if (now == f || (std::abs(now - f) < heat::phase_step && now > 0 && now < 1)) return false;
    T &J = s_.J_P.column(0)[p], &r = s_.radius.column(0)[p], &liquid = s_.liquid.column(0)[p];
    const double after = heat::ratio_after(J, f, now, m / double(s_.V0.column(0)[p]));
    const T before = r;
    r = T(double(r) * std::cbrt(after / double(J)));
    J = T(after), liquid = T(now);
    grown_[p] = r - before;
    freezes_[p] = now < f;
    return true;
  }

  void pair(std::size_t p, std::uint32_t e, double dt) {
    const auto q = std::size_t(lists_.row[e]);
    const T radii = s_.radius.column(0)[p] + s_.radius.column(0)[q];
    const T overlap = T(double(radii) - distance(s_, p, q));
    const T limit = T(0.5) * (strain_[p] + strain_[q]) * radii;
    const bool is_water = s_.liquid.column(0)[p] >= T(1) || s_.liquid.column(0)[q] >= T(1);
    if (changed_[p] || changed_[q]) {
      const Change change{T(overlap - (grown_[p] + grown_[q])),
                          overlap,
                          limit,
                          force_kept(p, q),
                          share_left(p, q),
                          is_water,
                          freezes_[p] || freezes_[q]};
      if (lists_.hold[e] > T(0) && lists_.a[e] - change.before <= lists_.hold[e])
        change_bond(e, change);
      else
        change_contact(e, change);
    }
    if (model_.sinters && !is_water && (lists_.hold[e] != T(0) || overlap > T(0)))
      sinter(p, q, e, overlap, limit, dt);
  }

  // The strain at which bonds of p break that freeze or sinter. Of snow without cohesion it is that at which a share of the cohesive
  // strength of its density pulls.
  T strain(std::size_t p) const {
    const double bond = s_.bond.column(0)[p], k = s_.k.column(0)[p], wet = s_.liquid.column(0)[p];
    if (bond > 0 || !(k > 0)) return T(bond);
    const double modulus = k / (double(s_.born.column(0)[p]) * (1 - wet * (1 - soft)));
    return T((1 - wet) * sintering::of_loose * std::max(cohesive_strength(density(p)), 0.0) / modulus);
  }

  // What becomes of a pair: its overlap before and now, and the stretch at which a bond of it breaks [m]; the share of its stretch
  // with which it pushes and pulls no more than before; the share of its strength that stays.
  struct Change {
    T before, now, limit, keep, left;
    bool is_water, freezes;
  };

  // Bonds keep their stretch while particles change their size, less what they grow stiffer: so their force stays and their energy does
  // not grow. Their strength falls as that of the snow does, with what sintering gave; it is that of the snow again where water
  // freezes. Water has no bonds, but for those that press until they part.
  void change_bond(std::uint32_t e, const Change& c) {
    T &hold = lists_.hold[e], &rest = lists_.a[e];
    rest = c.now - (c.before - rest) * c.keep;
    hold = c.is_water ? T(0) : T(hold * c.left);
    if (c.freezes && !c.is_water) hold = std::max(hold, c.limit);
    hold = std::max(hold, rest);
    if (!(hold > T(0))) hold = rest = T(0);
  }

  // What freezes is bonded to what it touches, pressed by the force with which it was. Where there is no bond, what would press more than
  // before, as it grows or grows stiffer, is at rest by as much, until it parts.
  void change_contact(std::uint32_t e, const Change& c) {
    T &hold = lists_.hold[e], &rest = lists_.a[e];
    if (hold > T(0)) hold = T(0);  // a bond that the next step would find broken
    const T pressed = std::max(c.before, T(0)) * c.keep;
    const T bears = std::max(c.limit, hold < T(0) ? T(-hold * c.left) : T(0));
    if (c.freezes && !c.is_water && bears > loose<T> && (hold < T(0) || c.now > T(0))) {
      const bool held = hold < T(0) && c.before > hold;
      rest = c.now - (held ? T(c.before * c.keep) : pressed);
      hold = std::max(bears, rest), lists_.b[e] = lists_.c[e] = T(0);
    } else if (c.now > pressed) {
      hold = rest = c.now - pressed, lists_.b[e] = lists_.c[e] = T(0);
    } else if (hold < T(0)) {
      hold = c.is_water ? -loose<T> : -std::max(T(-hold * c.left), loose<T>);
      for (auto* spring : {&lists_.a, &lists_.b, &lists_.c}) (*spring)[e] *= c.keep;
    }
  }

  // The share of its stretch with which a pair whose stiffness has grown has the force that it had.
  T force_kept(std::size_t p, std::size_t q) const {
    const T before = k_before_[p] + k_before_[q], now = s_.k.column(0)[p] + s_.k.column(0)[q];
    return now > before ? T(before / now) : T(1);
  }

  // The share of its strength that a pair keeps as one of its particles melts.
  T share_left(std::size_t p, std::size_t q) const {
    const T before = strain_before_[p] + strain_before_[q], now = strain_[p] + strain_[q];
    return before > T(0) ? std::min(T(now / before), T(1)) : T(1);
  }

  void sinter(std::size_t p, std::size_t q, std::uint32_t e, T overlap, T limit, double dt) {
    double v2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double v = double(s_.v.column(k)[p]) - double(s_.v.column(k)[q]);
      v2 += v * v;
    }
    const T held = lists_.hold[e];
    if (held > T(0) ? lists_.a[e] - overlap > held : held < T(0) && overlap <= held) return;  // it breaks
    const double radii = double(s_.radius.column(0)[p]) + double(s_.radius.column(0)[q]);
    const double slow = sintering::at_rest * radii;
    if (v2 > slow * slow || !(limit > T(0)) || limit > T(radii)) return;
    const double m_p = s_.m.column(0)[p], m_q = s_.m.column(0)[q];
    const double celsius =
        0.5 * (heat::temperature(s_.enthalpy[p], m_p) + heat::temperature(s_.enthalpy[q], m_q));
    const double rho = 0.5 * (density(p) + density(q));
    const double most = double(limit) * sintering::strength_of_ice(rho);
    T& hold = lists_.hold[e];
    const double now = std::max(std::abs(double(hold)), double(loose<T>));
    const T grown = T(sintering::grown(now, limit, most, celsius, dt));
    if (hold == T(0)) {  // a contact that no step has seen yet: its spring has not turned
      if (!(overlap > T(0))) return;
      lists_.a[e] = lists_.b[e] = lists_.c[e] = T(0);
    }
    hold = hold > T(0) ? grown : -grown;
  }
  double density(std::size_t p) const {
    return double(s_.m.column(0)[p]) / (double(s_.V0.column(0)[p]) * double(s_.J_P.column(0)[p]));
  }

  const HeatModel& model_;
  ParticleState<T>& s_;
  Neighbours<T>& lists_;
  std::vector<T> grown_, strain_;
  std::vector<char> freezes_, changed_;
  std::vector<T> strain_before_, k_before_;
};

}  // namespace detail

// Let heat flow for dt [s] of motion, and change particles and bonds as it makes them; `changed` gets by row whether the
// liquid share, and with it size and strength, has. `solids` hide what touches them from air and sun.
template <class T>
HeatReport pass_heat(const HeatModel& model, const std::vector<Solid<T>>& solids, ParticleState<T>& s,
                     Neighbours<T>& lists, const std::vector<ContactMaterial>& table, double dt,
                     std::vector<char>& changed) {
  const double own = dt * model.speed;
  const HeatReport report = detail::HeatFlow<T>(model, solids, s, lists).flow(own);
  changed.assign(s.count, 0);
  if (report.endless) return report;
  changed = detail::PhaseChange<T>(model, s, lists).apply(own, [&](std::size_t p) { derive(s, table, p); });
  return report;
}

}  // namespace neve
