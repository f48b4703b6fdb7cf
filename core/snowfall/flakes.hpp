// The way of a flake, followed backward: from where it may land up to the sky.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.hpp"

namespace neve::snowfall {

// Numbers that follow from a key and a count alone, so that no order of threads changes them.
class Draw {
 public:
  explicit Draw(std::uint64_t key) : state_(mixed(key)) {}
  // The final mixing of a 64-bit word.
  static std::uint64_t mixed(std::uint64_t v) {
    v += 0x9e3779b97f4a7c15ull;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
    return v ^ (v >> 31);
  }
  std::uint64_t word() { return mixed(state_ += 0x9e3779b97f4a7c15ull); }
  double uniform() { return (double(word() >> 11) + 0.5) * 0x1p-53; }  // in (0, 1)
  // Two independent normal deviates (Box and Muller).
  void normal(double& a, double& b) {
    const double r = std::sqrt(-2.0 * std::log(uniform())), turn = 6.283185307179586 * uniform();
    a = r * std::cos(turn), b = r * std::sin(turn);
  }

 private:
  std::uint64_t state_;
};

// How snow falls. A flake swings to and fro: its way is made of straight pieces, on each of which it moves sideways
// by a normal deviate of variance flutter^2 times the piece's height, along x and y each, and with the wind.
//
// Source: Fearing 2000, flake flutter and launch sites, in the author's description; the pieces are ours.
struct Weather {
  double flutter;  // sideways way along each axis over 1 m of fall, root mean square [m^(1/2)]
  double wind[2];  // of the air over the speed of fall [1]
  std::uint64_t seed;
};

constexpr double shortest_piece = 0.2;  // height of a piece near the ground [m]
constexpr double piece_growth = 0.15;   // of a piece, over the height above the start [1]

inline double piece_height(double risen) { return std::fmax(shortest_piece, piece_growth * risen); }

// Follow a flake from `at`, a point of a surface of the given slope (dz/dx, dz/dy), up to the height `top`.
//
// Returns what it brings, in units of what falls on level open ground: 0 if something is in its way, otherwise the
// mass that comes from its direction through the surface over one unit of its area seen from above,
// 1 - slope . (sideways way over the height of the first piece).
inline double arrives(const std::vector<const TriangleMesh*>& solids, const Weather& weather, Point at,
                      const double slope[2], double top, Draw& draw) {
  double weight = 0, risen = 0;
  for (bool first = true; first || at.z < top; first = false) {
    const double height = piece_height(risen), swing = weather.flutter * std::sqrt(height);
    double a = 0, b = 0;
    if (swing > 0) draw.normal(a, b);
    const Point way{swing * a - weather.wind[0] * height, swing * b - weather.wind[1] * height, height};
    if (first) {
      weight = 1.0 - (slope[0] * way.x + slope[1] * way.y) / height;
      if (!(weight > 0)) return 0.0;
    }
    for (const TriangleMesh* solid : solids) {
      if (solid->blocked(at, way, 1.0)) return 0.0;
    }
    at = at + way, risen += height;
  }
  return weight;
}

}  // namespace neve::snowfall
