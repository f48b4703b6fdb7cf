// Which snow stays where it fell: steep snow slides to its lower neighbours, or over an edge, until all is stable.
#pragma once

#include <numeric>

#include "snowfall/columns.hpp"

namespace neve::snowfall {

// What snow bears.
//
// Sources: the angle of repose against each neighbour is Fearing 2000's; the depth that a slope holds is Bernhardt
// and Schulz 2010's SnowSlide, holding = 3178 beta^-1.998 m, beta in degrees (constants from memory).
struct Stability {
  double repose;         // tangent of the angle of repose [1]
  bool holding_depth;    // let only snow slide that is deeper than its slope holds
  double least_slope;    // tangent below which nothing slides by its depth [1]
  double gravity;        // [m/s2]
  std::uint32_t passes;  // over all snow that moves, at most
};

inline double holding_depth(double slope) {
  const double degrees = std::atan(slope) * 57.29577951308232;
  return degrees > 0 ? 3178.0 * std::pow(degrees, -1.998) : Columns::inf;
}

struct Slid {
  double lost = 0;           // snow that fell into the void or over the rim, as a sum of depths [m]
  double moved = 0;          // way from site to site, counted each time [m]
  double over_edges = 0;     // of that what fell over edges [m]
  std::uint32_t passes = 0;  // that moved anything
  bool settled = true;       // nothing moves any more
};

// Sites are taken from the highest down, so that what slides reaches the foot in one pass. One thread: each move
// follows from those before it.
class Slides {
 public:
  static constexpr double slack = 1e-3;  // slope above that of repose that still rests [1]
  static constexpr double crumb = 1e-9;  // depth that is none [m]

  // depth: of the snow on each site (sites,) [m], which slides.
  Slides(const Columns& columns, const Stability& law, std::vector<double>& depth)
      : columns_(columns), law_(law), depth_(depth), energy_(depth.size()), moving_(depth.size()) {}

  Slid run() {
    Slid out;
    std::vector<std::uint32_t> order(depth_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<bool> wakes(depth_.size(), true);
    while (!order.empty()) {
      if (out.passes == law_.passes) {
        out.settled = false;
        break;
      }
      std::sort(order.begin(), order.end(),
                [&](std::uint32_t a, std::uint32_t b) { return top(a) != top(b) ? top(a) > top(b) : a < b; });
      std::fill(energy_.begin(), energy_.end(), 0.0), std::fill(moving_.begin(), moving_.end(), 0.0);
      std::fill(wakes.begin(), wakes.end(), false);
      woken_.clear();
      for (std::uint32_t s : order) relax(s, out);
      if (woken_.empty()) break;
      ++out.passes;
      order.clear();
      for (std::uint32_t s : woken_) wake_around(s, wakes, order);
    }
    return out;
  }

 private:
  struct Way {
    std::uint32_t to;  // none: into the void
    int di, dj;
    double excess;  // by which it is too steep [m]
    double run;     // between the middles of the cells [m]
  };

  double top(std::uint32_t s) const { return columns_.sites()[s].z + depth_[s]; }

  // Let what is too much on s go where it is too steep.
  void relax(std::uint32_t s, Slid& out) {
    if (!(depth_[s] > crumb)) return;
    const double free = law_.holding_depth ? depth_[s] - held(s) : depth_[s];
    if (!(free > crumb)) return;
    Way ways[8];
    const int count = find_ways(s, ways);
    if (count == 0) return;
    double total = 0;
    for (int k = 0; k < count; ++k) total += share(ways[k], count);
    if (!(total > crumb)) return;
    const double part = std::min(1.0, free / total);
    const double carried = moving_[s] > 0 ? energy_[s] / std::max(moving_[s], total * part) : 0.0;
    for (int k = 0; k < count; ++k) move(s, ways[k], share(ways[k], count) * part, carried, out);
  }
  // What goes one way: so much that, were all ways alike, the slope would become that of repose.
  double share(const Way& way, int count) const { return way.excess / (count + 1); }

  double held(std::uint32_t s) const {
    const Site& site = columns_.sites()[s];
    const double slope = std::sqrt(site.slope[0] * site.slope[0] + site.slope[1] * site.slope[1]);
    return slope < law_.least_slope ? Columns::inf : holding_depth(slope);
  }

  int find_ways(std::uint32_t s, Way* ways) const {
    const Raster& raster = columns_.raster();
    const auto [i, j] = columns_.place(s);
    const double height = top(s);
    bool open[3][3] = {};
    int count = 0;
    for (int pass = 0; pass < 2; ++pass) {  // straight ways first: a slanting one is shut between two walls
      for (int di = -1; di <= 1; ++di) {
        for (int dj = -1; dj <= 1; ++dj) {
          if ((di != 0) + (dj != 0) != pass + 1 || !raster.holds(i + di, j + dj)) continue;
          if (pass == 1 && !open[1 + di][1] && !open[1][1 + dj]) continue;
          const std::size_t column = raster.column(i + di, j + dj);
          const double run = raster.cell * (pass == 0 ? 1.0 : 1.4142135623730951);
          if (columns_.rises(s, column, height, run)) continue;
          const std::uint32_t to = columns_.below(column, height);
          if (to == Columns::none && !columns_.bottomless(column, height)) continue;
          open[1 + di][1 + dj] = true;
          const double steep = law_.holding_depth ? 0.0 : run * law_.repose;
          // at an edge, only what lies higher than the slope of repose that begins there
          const double excess =
              is_edge(s, to, run) ? 2.0 * (depth_[s] - 0.5 * run * law_.repose) : height - top(to) - steep;
          if (!(excess > slack * run) || (to != Columns::none && !(room(to) > crumb))) continue;
          ways[count++] = {to, di, dj, excess, run};
        }
      }
    }
    return count;
  }
  // Whether the way from s leads over an edge of the surface that s is on.
  bool is_edge(std::uint32_t s, std::uint32_t to, double run) const {
    return to == Columns::none || top(to) < columns_.sites()[s].z - Columns::steepest * run;
  }
  double room(std::uint32_t s) const {
    const double ceiling = columns_.sites()[s].ceiling;
    return ceiling < Columns::inf ? ceiling - top(s) : Columns::inf;
  }

  // Move some snow on: down a slope, or over an edge with the speed that it has.
  void move(std::uint32_t s, const Way& way, double amount, double energy, Slid& out) {
    std::uint32_t to = way.to;
    const bool falls = is_edge(s, to, way.run);
    if (falls) {
      to = landing(s, way, std::sqrt(2.0 * energy));
      energy = 0;  // it comes to rest where it lands
    } else {
      energy += law_.gravity * std::max(0.0, top(s) - top(to) - law_.repose * way.run);
    }
    amount = std::min(amount, depth_[s]);
    if (to != Columns::none) amount = std::min(amount, std::max(0.0, room(to)));
    if (!(amount > 0)) return;
    depth_[s] -= amount;
    woken_.push_back(s);
    out.moved += amount;
    if (falls) out.over_edges += amount;
    if (to == Columns::none) {
      out.lost += amount;
      return;
    }
    depth_[to] += amount;
    energy_[to] += amount * energy, moving_[to] += amount;
    woken_.push_back(to);
  }

  // Where snow lands that leaves s over an edge along its surface with a speed [m/s]: it falls freely until it
  // meets a surface; a wall stops it. None: it falls into a void or beyond the rim.
  std::uint32_t landing(std::uint32_t s, const Way& way, double speed) const {
    const Raster& raster = columns_.raster();
    const auto [i, j] = columns_.place(s);
    const double* slope = columns_.sites()[s].slope;
    const double start = top(s), length = std::sqrt(double(way.di * way.di + way.dj * way.dj));
    const double descent = std::max(0.0, -(slope[0] * way.di + slope[1] * way.dj) / length);
    const double level = speed / std::sqrt(1.0 + descent * descent);
    std::uint32_t under = way.to;
    std::size_t column = raster.column(i + way.di, j + way.dj);
    for (double gone = way.run;; gone += 0.5 * raster.cell) {
      const double cells = gone / raster.cell / length;
      const auto a = std::int32_t(std::floor(i + 0.5 + way.di * cells)),
                 b = std::int32_t(std::floor(j + 0.5 + way.dj * cells));
      if (!raster.holds(a, b)) return Columns::none;
      const double time = level > 0 ? (gone - 0.5 * way.run) / level : Columns::inf;
      const double z = start - (level * descent + 0.5 * law_.gravity * time) * time;
      const std::size_t next = raster.column(a, b);
      if (next != column) {
        const std::uint32_t found = columns_.below(next, z);
        const bool shut = found == Columns::none && !columns_.bottomless(next, z);
        if (shut) return under;  // a wall, or the ground was met on the way
        column = next, under = found;
      }
      if (under != Columns::none ? z <= top(under) : !(z > -Columns::inf)) return under;
    }
  }

  // Every site that a change on s may make unstable.
  void wake_around(std::uint32_t s, std::vector<bool>& wakes, std::vector<std::uint32_t>& order) const {
    const Raster& raster = columns_.raster();
    const auto [i, j] = columns_.place(s);
    for (int di = -1; di <= 1; ++di) {
      for (int dj = -1; dj <= 1; ++dj) {
        if (!raster.holds(i + di, j + dj)) continue;
        const std::size_t c = raster.column(i + di, j + dj);
        for (std::uint32_t o = columns_.begin(c); o < columns_.end(c); ++o) {
          if (wakes[o] || !(depth_[o] > crumb)) continue;
          wakes[o] = true;
          order.push_back(o);
        }
      }
    }
  }

  const Columns& columns_;
  Stability law_;
  std::vector<double>& depth_;
  std::vector<double> energy_, moving_;  // of what came in this pass: depth times v^2 / 2, and depth
  std::vector<std::uint32_t> woken_;
};

}  // namespace neve::snowfall
