// Heat that flows between particles, and to them from air and sun.
#pragma once

#include <bit>

#include "heat/enthalpy.hpp"
#include "heat/sunlight.hpp"
#include "mpm/model.hpp"
#include "particles/heat/facets.hpp"
#include "particles/listing.hpp"

namespace neve {

namespace detail {

// Gap over the radii's sum across which ice or water connects two particles.
inline constexpr double bridge = 0.3;
// Area of a loose contact over that of a bond [1].
inline constexpr double touching = 0.3;
// Area of a bond over pi min(r)^2: so packed snow conducts as its conductivity says.
inline constexpr double area_of_bond = 0.79;
// Cosine of the angle around a neighbour in which it hides a particle's surface.
inline constexpr double blocked = 0.5;
// Growth of the open facets with the share that is hidden, towards the air and towards the sun: so a plane surface of
// packed snow has the plane's area, and a particle alone that of its ball.
inline constexpr double growth_in_air = 0.45, growth_in_sun = 1.3;

// A pass over the heat of all particles. Pairs are computed from both sides with the same bits.
template <class T>
class HeatFlow {
 public:
  HeatFlow(const HeatModel& model, const std::vector<Solid<T>>& solids, ParticleState<T>& s,
           const Neighbours<T>& lists)
      : model_(model),
        solids_(solids),
        s_(s),
        lists_(lists),
        conductance_(lists.size()),
        k_(s.count),
        temperature_(s.count),
        from_air_(s.count),
        from_sun_(s.count),
        taken_(s.count) {}

  // Let heat flow for dt [s], of its own time.
  HeatReport flow(double dt) {
    const std::vector<char> lit = model_.sun > 0 ? lit_ones() : std::vector<char>(s_.count, 0);
    each([&](std::size_t p) {
      const double f = s_.liquid.column(0)[p];
      k_[p] = model_.conductivity_of(double(s_.m.column(0)[p]) / volume(p), f);
    });
    std::vector<double> rate(s_.count);
    each([&](std::size_t p) { rate[p] = connect(p) + expose(p, lit[p]); });
    return flow_in_rounds(
        dt, s_.count, [&](std::size_t p) { return rate[p]; },
        [&](std::size_t p) { return double(s_.m.column(0)[p]); }, [&](double round) { exchange(round); },
        s_.enthalpy.data(), taken_.data());
  }

 private:
  template <class F>
  void each(F&& f) {
    each_chunk(s_.count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) f(p);
    });
  }
  // Whom the sun reaches: squares are two radii wide, and 2.5 radii deep.
  std::vector<char> lit_ones() const {
    double radius = 0;
    for (std::size_t p = 0; p < s_.count; ++p) radius = std::max(radius, double(s_.radius.column(0)[p]));
    const auto place = [&](std::size_t p) {
      return std::array<double, 3>{double(s_.x.column(0)[p]), double(s_.x.column(1)[p]),
                                   double(s_.x.column(2)[p])};
    };
    return sunlit(s_.count, place, 2 * radius, 2.5 * radius, model_.towards);
  }
  double volume(std::size_t p) const { return double(s_.V0.column(0)[p]) * double(s_.J_P.column(0)[p]); }

  // Find the conductances of p's pairs [W/K], and return their sum.
  double connect(std::size_t p) {
    double sum = 0;
    lists_.each(p, [&](std::uint32_t e) {
      const auto q = std::size_t(lists_.row[e]);
      const double r_p = s_.radius.column(0)[p], r_q = s_.radius.column(0)[q], d = distance(s_, p, q);
      const bool wet = s_.liquid.column(0)[p] > 0 || s_.liquid.column(0)[q] > 0, held = lists_.hold[e] > T(0);
      double area = 0;
      if (held || (wet && d <= (1 + bridge) * (r_p + r_q)))
        area = 1;
      else if (d <= r_p + r_q || lists_.hold[e] < T(0))
        area = touching;
      const double r = std::min(r_p, r_q), k = 2 * k_[p] * k_[q] / (k_[p] + k_[q]);
      conductance_[e] = area > 0 ? k * area_of_bond * area * 3.14159265358979 * r * r / std::max(d, r) : 0;
      sum += conductance_[e];
    });
    return sum;
  }

  // The facets of p's surface that no neighbour hides, and from which no solid is a radius away or less: within 60 degrees of the
  // normal of one that it touches.
  std::uint32_t open_facets(std::size_t p) const {
    std::uint32_t open = ~std::uint32_t(0);
    const auto hide = [&](const std::array<double, 3>& n, double least) {
      for (std::size_t i = 0; i < facet_count; ++i) {
        const auto& facet = facets()[i];
        if (n[0] * facet[0] + n[1] * facet[1] + n[2] * facet[2] > least) open &= ~(std::uint32_t(1) << i);
      }
    };
    lists_.each(p, [&](std::uint32_t e) {
      if (!open) return;
      const auto q = std::size_t(lists_.row[e]);
      const double d = distance(s_, p, q);
      if (d > (1 + bridge) * (double(s_.radius.column(0)[p]) + double(s_.radius.column(0)[q]))) return;
      std::array<double, 3> n{};
      for (std::size_t k = 0; k < 3; ++k)
        n[k] = double(s_.x.column(int(k))[q]) - double(s_.x.column(int(k))[p]);
      hide(n, blocked * d);
    });
    const Vec3<T> x{s_.x.column(0)[p], s_.x.column(1)[p], s_.x.column(2)[p]};
    const T far = T(1 / blocked) * s_.radius.column(0)[p];
    for (const Solid<T>& solid : solids_) {
      if (!open || !is_near(solid, x, far)) continue;
      const auto at = surface(solid, x);
      if (at.phi < far)
        hide({-double(at.normal.x), -double(at.normal.y), -double(at.normal.z)},
             double(at.phi) / double(far));
    }
    return open;
  }

  // Find what p gets from the air per kelvin [W/K], which is returned, and from the sun [W].
  double expose(std::size_t p, bool lit) {
    const std::uint32_t open = open_facets(p);
    const double r = std::cbrt(volume(p) * 0.75 / 3.14159265358979);
    const double hidden = 1 - std::popcount(open) / double(facet_count);
    const double area = 4 * 3.14159265358979 * r * r, facet_area = area / facet_count;
    double facing = 0;
    for (std::size_t i = 0; i < facet_count; ++i) {
      if (!(open >> i & 1)) continue;
      double cosine = 0;
      for (std::size_t k = 0; k < 3; ++k) cosine += facets()[i][k] * model_.towards[k];
      facing += facet_area * std::max(cosine, 0.0);
    }
    const double free = area * (1 - hidden) * (1 + growth_in_air * hidden);
    facing *= 1 + growth_in_sun * hidden;
    from_air_[p] = model_.exchange * free;
    from_sun_[p] = lit ? model_.sun * facing : 0;
    return from_air_[p];
  }

  // Let heat flow for a round of dt [s].
  void exchange(double dt) {
    each([&](std::size_t p) { temperature_[p] = heat::temperature(s_.enthalpy[p], s_.m.column(0)[p]); });
    each([&](std::size_t p) {
      double between = 0;
      lists_.each(p, [&](std::uint32_t e) {
        between += conductance_[e] * (temperature_[std::size_t(lists_.row[e])] - temperature_[p]);
      });
      const double outside = dt * (from_air_[p] * (model_.air - temperature_[p]) + from_sun_[p]);
      s_.enthalpy[p] += dt * between + outside;
      taken_[p] += outside;
    });
  }

  const HeatModel& model_;
  const std::vector<Solid<T>>& solids_;
  ParticleState<T>& s_;
  const Neighbours<T>& lists_;
  std::vector<double> conductance_, k_, temperature_, from_air_, from_sun_, taken_;
};

}  // namespace detail

}  // namespace neve
