// Directions in which the surface of a particle is looked at.
#pragma once

#include <array>
#include <cmath>

namespace neve {

// The corners of an icosahedron and of a dodecahedron.
inline constexpr int facet_count = 32;
inline const std::array<std::array<double, 3>, facet_count>& facets() {
  static const auto all = [] {
    const double g = (1 + std::sqrt(5.0)) / 2, far = std::sqrt(1 + g * g), root = std::sqrt(3.0);
    std::array<std::array<double, 3>, facet_count> out{};
    std::size_t n = 0;
    for (int signs = 0; signs < 4; ++signs) {
      const double a = signs & 1 ? 1 : -1, b = signs & 2 ? 1 : -1;
      for (std::size_t k = 0; k < 3; ++k) {
        out[n][k] = 0, out[n][(k + 1) % 3] = a / far, out[n][(k + 2) % 3] = b * g / far, ++n;
        out[n][k] = 0, out[n][(k + 1) % 3] = a / g / root, out[n][(k + 2) % 3] = b * g / root, ++n;
      }
      for (const double c : {-1.0, 1.0}) out[n++] = {a / root, b / root, c / root};
    }
    return out;
  }();
  return all;
}

}  // namespace neve
