// What arrives of sun and sky at points of the set: found on the nodes of a coarse lattice, interpolated between them.
#pragma once

#include <array>

#include "render/ground.hpp"

namespace neve::render {

// Shares of the sun past snow, solids at rest and other solids, and of the sky.
enum Share { snow_sun, snow_sky, static_sun, static_sky, moving_sun, moving_sky };
constexpr Share shares_of_light[6] = {snow_sun, snow_sky, static_sun, static_sky, moving_sun, moving_sky};
using Arrival = std::array<float, 6>;

inline Vec3f compose(const SetPoint& set, const Arrival& a) {
  return set.sun * (a[snow_sun] * a[static_sun] * a[moving_sun]) +
         set.sky * (a[snow_sky] * a[static_sky] * a[moving_sky]) + set.unshadowed;
}

// A node of the lattice: what is seen there and what arrives.
struct Node {
  static constexpr int unknown = -2;

  Arrival arrival{1, 1, -1, -1, 1, 1};
  Vec3f point{};
  Hit hit;
  int solid = unknown;
  bool placed = false;   // whether solid and hit are those of this frame
  bool shown = false;    // whether what arrives is that of this frame
  bool changed = false;  // whether anything of it differs from what it was when it was last shown
};

// The four nodes around a cell.
struct Corners {
  const Node* node[4];

  // Whether what arrives is known at all of them, and the same solid is seen there.
  bool show(int solid) const {
    for (const Node* n : node)
      if (!n->shown || n->solid != solid) return false;
    return true;
  }
  bool changed() const {
    return node[0]->changed || node[1]->changed || node[2]->changed || node[3]->changed;
  }

  // How much a share may differ between nodes that are interpolated. The snow's shadow has no details finer than the
  // density's cells: nodes closer than that may differ. cell_size: of the density [m].
  float tolerance(Share share, float cell_size) const {
    if (share != snow_sun) return smooth;
    const Vec3f one = node[3]->point - node[0]->point, other = node[2]->point - node[1]->point;
    const float far = std::max(dot(one, one), dot(other, other)), near = 2.5f * cell_size;
    return std::clamp(0.12f * near * near / std::max(far, 1e-20f), smooth, 1.0f);
  }
  // Whether the nodes are so alike in a share that it may be interpolated.
  bool alike(Share share, float cell_size) const {
    const auto [least, most] =
        std::minmax({value(0, share), value(1, share), value(2, share), value(3, share)});
    return most - least < tolerance(share, cell_size);
  }
  // A share at the place (a, b) between the nodes, from 0 to 1 along each axis.
  float between(Share share, float a, float b) const {
    return mix(mix(value(0, share), value(1, share), b), mix(value(2, share), value(3, share), b), a);
  }

 private:
  // Between nodes that differ by more than this the light is found pixel by pixel.
  static constexpr float smooth = 0.06f;

  float value(int n, Share share) const { return node[n]->arrival[share]; }
};

}  // namespace neve::render
