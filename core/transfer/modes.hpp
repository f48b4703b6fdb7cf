// The scalar modes of a velocity field around a particle: products over the axes of one-dimensional polynomials
//     phi_0 = 1,   phi_1 = z,   phi_2 = z^2 - (M3 / M2) z - M2     (M_k = sum_i w_i z_i^k of the axis)
// of the offset z = x_i - x_p in cells. They are orthogonal under the weights: sum_i w_i phi_a phi_b = 0 for a != b.
#pragma once

#include "math/standard.hpp"

namespace neve {

// The degrees of a mode along x, y and z.
struct Mode {
  int degree[3];
};

// One value for each mode.
template <class E, int Count>
struct PerMode {
  E value[Count]{};
  constexpr E& operator[](int n) { return value[n]; }
  constexpr const E& operator[](int n) const { return value[n]; }
};

// The modes of `Q` degrees per axis, in the order in which they are stored: 1; x, y, z; yz, xz, xy, xyz (the last
// index moves first); then, in the same order, all with a phi_2. Q = 2 is the beginning of Q = 3.
template <int Q>
constexpr PerMode<Mode, Q * Q * Q> mode_order() {
  PerMode<Mode, Q * Q * Q> modes;
  modes[1].degree[0] = modes[2].degree[1] = modes[3].degree[2] = 1;
  int next = 4;
  for (int top = 1; top < Q; ++top) {
    for (int n = 0; n < Q * Q * Q; ++n) {
      const int a = n / (Q * Q), b = n / Q % Q, c = n % Q;
      const int highest = a > b ? (a > c ? a : c) : (b > c ? b : c);
      if (highest != top || a + b + c < 2) continue;
      modes[next++] = {{a, b, c}};
    }
  }
  return modes;
}
template <int Q>
inline constexpr auto modes_of = mode_order<Q>();

// The place of the mode of degrees a, b, c in that order.
template <int Q>
constexpr int mode_index(int a, int b, int c) {
  int found = 0;
  for (int n = 0; n < Q * Q * Q; ++n) {
    const int* d = modes_of<Q>[n].degree;
    if (d[0] == a && d[1] == b && d[2] == c) found = n;
  }
  return found;
}
template <int Q>
inline constexpr auto mode_places = [] {
  PerMode<int, Q * Q * Q> places;
  for (int n = 0; n < Q * Q * Q; ++n) places[n] = mode_index<Q>(n / (Q * Q), n / Q % Q, n % Q);
  return places;
}();

}  // namespace neve
