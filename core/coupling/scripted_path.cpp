#include "coupling/scripted_path.hpp"

#include <algorithm>
#include <cmath>

namespace neve {

namespace {

// The rotation by `angle` about the unit vector `axis` (Rodrigues), element by element.
std::array<double, 9> turned(const std::array<double, 3>& axis, double angle) {
  const double x = axis[0], y = axis[1], z = axis[2];
  const double sine = std::sin(angle), half = std::sin(0.5 * angle), rest = 2 * half * half;
  return {1 + rest * (-z * z - y * y), rest * (y * x) - sine * z,   sine * y + rest * (z * x),
          sine * z + rest * (x * y),   1 + rest * (-z * z - x * x), rest * (z * y) - sine * x,
          rest * (x * z) - sine * y,   sine * x + rest * (y * z),   1 + rest * (-y * y - x * x)};
}

std::array<double, 9> product(const std::array<double, 9>& a, const std::array<double, 9>& b) {
  std::array<double, 9> out;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  }
  return out;
}

}  // namespace

ScriptedPose ScriptedPath::at(double t) const {
  const auto later = std::upper_bound(starts_.begin(), starts_.end(), t);
  const ScriptedLeg& leg = legs_[std::size_t(later - starts_.begin())];
  const double share = (t - leg.begin) / leg.span;
  ScriptedPose out{leg.position, leg.rotation, leg.velocity, leg.omega};
  for (std::size_t k = 0; k < 3; ++k) out.position[k] += share * leg.way[k];
  if (leg.angle != 0) out.rotation = product(turned(leg.axis, share * leg.angle), leg.rotation);
  return out;
}

std::array<double, 4> quaternion_of(const std::array<double, 9>& m) {
  const double trace = m[0] + m[4] + m[8];
  const double squares[4] = {trace, 2 * m[0] - trace, 2 * m[4] - trace, 2 * m[8] - trace};  // 4 q_k^2 - 1
  const std::ptrdiff_t k = std::max_element(squares, squares + 4) - squares;
  const double x = m[7] - m[5], y = m[2] - m[6], z = m[3] - m[1];  // 4 w times the axis
  const double xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7];
  const double own = 1 + squares[k];
  std::array<double, 4> q = k == 0   ? std::array{own, x, y, z}
                            : k == 1 ? std::array{x, own, xy, xz}
                            : k == 2 ? std::array{y, xy, own, yz}
                                     : std::array{z, xz, yz, own};
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double signed_length = q[0] < 0 ? -length : length;
  for (double& component : q) component /= signed_length;
  return q;
}

}  // namespace neve
