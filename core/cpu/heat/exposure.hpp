// Which part of the surface of the snow is whose: areas that air and sun reach (docs/heat.md).
//
// phi_i = sum_p w_ip V_p / dx^3 is the share of the space around node i that snow fills. Between 0.2 and 0.8 it is stretched to
// psi, from 0 to 1, so that uneven filling inside makes no surface. By the coarea formula the
// surface has the area of the integral of |grad psi|, its outward normal is -grad psi / |grad psi|, and what faces the sun
// the integral of (-grad psi . s)+. Solids fill space as snow does, and what they have of both by themselves is taken away, so
// that snow is free only where it touches none. Each cell gives its part to its nodes as they are filled, and each node to its particles.
// What fills less than half of its surroundings is spray, and has the surface of a ball of its volume in that measure.
#pragma once

#include "cpu/heat/nodes.hpp"
#include "cpu/near.hpp"
#include "heat/sunlight.hpp"

namespace neve::detail {

template <class T>
class Exposure {
 public:
  // Areas of each particle [m2]: that air reaches, and that faces the sun and is lit.
  std::vector<double> to_air, to_sun;

  // `volume`: of the particles [m3].
  Exposure(const Model<T>& model, const HeatModel& heat, const State<T>& state, HeatNodes<T>& nodes,
           const std::vector<double>& volume)
      : to_air(state.count), to_sun(state.count), dx_(model.dx), nodes_(nodes), filled_(nodes.size()) {
    const double cell = dx_ * dx_ * dx_;
    nodes.template scatter<1>({filled_.data()}, [&](std::size_t p) { return std::array{volume[p] / cell}; });
    stretch(model);
    measure(heat);
    std::vector<double> spray(state.count);  // the area of its drops' discs
    nodes.template gather<1>({filled_.data()}, [&](std::size_t p, const std::array<double, 1>& around) {
      constexpr double pi = 3.14159265358979;
      const double alone = std::max(1 - 2 * around[0], 0.0);
      if (!(alone > 0)) return;
      const double r = std::cbrt(volume[p] * 0.75 / pi);
      spray[p] = alone * pi * r * r;
    });
    std::vector<char> lit(state.count);
    if (heat.sun > 0) shade(heat, state, spray, lit);
    share();
    nodes.template gather<2>({air_.data(), sun_.data()},
                             [&](std::size_t p, const std::array<double, 2>& areas) {
                               const double share = volume[p] / cell;
                               to_air[p] = std::max(share * areas[0], 4 * spray[p]);
                               to_sun[p] = std::max(share * areas[1], lit[p] ? spray[p] : 0.0);
                             });
  }

 private:
  static constexpr double low = 0.2, high = 0.8, wide = 1.5, deep = 5;  // of phi [1], [cells]

  // The slope of psi across a cell, by what its eight corners have.
  struct Slope {
    double slope[3] = {0, 0, 0};

    void add(const int (&corner)[3], double psi) {
      for (int a = 0; a < 3; ++a) slope[a] += (corner[a] ? 0.25 : -0.25) * psi;
    }
    double size() const { return std::sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2]); }
    double facing(const std::array<double, 3>& sun) const {
      return std::max(-slope[0] * sun[0] - slope[1] * sun[1] - slope[2] * sun[2], 0.0);
    }
  };

  template <class F>
  void each_node(F&& f) {
    each_index(nodes_.blocks().size(), [&](std::size_t b) {
      for (int n = 0; n < 64; ++n) f(b, n / 16, n / 4 % 4, n % 4, b * 64 + std::size_t(n));
    });
  }

  void stretch(const Model<T>& model) {
    psi_.resize(filled_.size()), solid_.resize(filled_.size());
    const SolidBalls<T> balls(model);
    each_index(nodes_.blocks().size(), [&](std::size_t b) {
      const BlockCoord at = nodes_.blocks()[b];
      const auto near = near_solids(model, balls, at, 1.5, 3.2);
      for (int n = 0; n < 64; ++n) {
        const Vec3<T> x = way_to_node(model, n);
        double solid = 0;
        for (const Solid<T>& s : near)
          solid = std::max(solid, std::clamp(0.5 - double(surface(s, x).phi) / dx_, 0.0, 1.0));
        const auto stretched = [](double phi) { return std::clamp((phi - low) / (high - low), 0.0, 1.0); };
        const std::size_t node = b * 64 + std::size_t(n);
        psi_[node] = stretched(filled_[node] + solid), solid_[node] = stretched(solid);
      }
    });
  }

  // The areas of cells, over what their nodes are filled: of the cell above each node.
  void measure(const HeatModel& heat) {
    air_.assign(filled_.size(), 0), sun_.assign(filled_.size(), 0);
    cell_air_.assign(filled_.size(), 0), cell_sun_.assign(filled_.size(), 0);
    const double face = dx_ * dx_;
    each_node([&](std::size_t b, int i, int j, int k, std::size_t n) {
      Slope all, solid;
      double filled = 0;
      for (int c = 0; c < 8; ++c) {
        const int d[3] = {c >> 2, c >> 1 & 1, c & 1};
        const std::size_t m = nodes_.at(b, i + d[0], j + d[1], k + d[2]);
        if (m == nodes_.none) continue;
        filled += filled_[m];
        all.add(d, psi_[m]), solid.add(d, solid_[m]);
      }
      if (!(filled > 0)) return;
      cell_air_[n] = std::max(all.size() - solid.size(), 0.0) * face / filled;
      cell_sun_[n] = std::max(all.facing(heat.towards) - solid.facing(heat.towards), 0.0) * face / filled;
    });
  }

  // Take the sun from cells that lie behind others, and see which drops of `spray` it reaches.
  void shade(const HeatModel& heat, const State<T>& state, const std::vector<double>& spray,
             std::vector<char>& lit) {
    std::vector<std::size_t> cells, drops;
    for (std::size_t n = 0; n < cell_sun_.size(); ++n) {
      if (cell_sun_[n] > 0) cells.push_back(n);
    }
    for (std::size_t p = 0; p < spray.size(); ++p) {
      if (spray[p] > 0) drops.push_back(p);
    }
    const auto place = [&](std::size_t k) {
      std::array<double, 3> x{};
      if (k >= cells.size()) {
        for (int a = 0; a < 3; ++a) x[std::size_t(a)] = double(state.x.column(a)[drops[k - cells.size()]]);
        return x;
      }
      const std::size_t n = cells[k];
      const BlockCoord at = nodes_.blocks()[n / 64];
      const std::int32_t block[3] = {at.x, at.y, at.z};
      const std::size_t node[3] = {n % 64 / 16, n / 4 % 4, n % 4};
      for (std::size_t a = 0; a < 3; ++a) x[a] = (4.0 * block[a] + double(node[a]) + 0.5) * dx_;
      return x;
    };
    const auto reached = sunlit(cells.size() + drops.size(), place, wide * dx_, deep * dx_, heat.towards);
    for (std::size_t k = 0; k < cells.size(); ++k) {
      if (!reached[k]) cell_sun_[cells[k]] = 0;
    }
    for (std::size_t k = 0; k < drops.size(); ++k) lit[drops[k]] = reached[cells.size() + k];
  }

  // Give the areas of cells to their nodes, over what these are filled.
  void share() {
    each_node([&](std::size_t b, int i, int j, int k, std::size_t n) {
      if (!(filled_[n] > 0)) return;
      for (int c = 0; c < 8; ++c) {
        const std::size_t m = nodes_.at(b, i - (c >> 2), j - (c >> 1 & 1), k - (c & 1));
        if (m == nodes_.none) continue;
        air_[n] += cell_air_[m], sun_[n] += cell_sun_[m];
      }
    });
  }

  double dx_;
  HeatNodes<T>& nodes_;
  std::vector<double> filled_, psi_, solid_, air_, sun_, cell_air_, cell_sun_;
};

}  // namespace neve::detail
