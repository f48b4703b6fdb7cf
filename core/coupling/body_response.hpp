// One contact of snow with a body whose velocity is not known yet: what each does to the other, for any velocities of the
// bodies. The bodies' velocities U are six numbers each: velocity [m/s], angular velocity [rad/s].
#pragma once

#include "coupling/contacts.hpp"
#include "coupling/exchange.hpp"

namespace neve {

// What the snow does to one body: impulse and moment about its centre, and how fast they fall as the body moves.
struct BodyResponse {
  double impulse[6] = {}, slope[36] = {};

  void add(const BodyResponse& o) {
    for (int k = 0; k < 6; ++k) impulse[k] += o.impulse[k];
    for (int k = 0; k < 36; ++k) slope[k] += o.slope[k];
  }

  // Add one node: mass m gets dv, and v' changes by D when the surface's velocity does, at `arm` from the centre.
  void add(double m, const double (&arm)[3], const double (&dv)[3], const double (&D)[3][3]) {
    // B maps the body's velocities to that of the surface: v_co = V + omega x arm
    const double B[3][6] = {
        {1, 0, 0, 0, arm[2], -arm[1]}, {0, 1, 0, -arm[2], 0, arm[0]}, {0, 0, 1, arm[1], -arm[0], 0}};
    double DB[3][6];
    for (int i = 0; i < 3; ++i) {
      for (int c = 0; c < 6; ++c) DB[i][c] = D[i][0] * B[0][c] + D[i][1] * B[1][c] + D[i][2] * B[2][c];
    }
    for (int r = 0; r < 6; ++r) {
      impulse[r] -= m * (B[0][r] * dv[0] + B[1][r] * dv[1] + B[2][r] * dv[2]);
      for (int c = 0; c < 6; ++c)
        slope[6 * r + c] += m * (B[0][r] * DB[0][c] + B[1][r] * DB[1][c] + B[2][r] * DB[2][c]);
    }
  }
};

// Where a surface faces snow at x that moves with v, as long as it is not known how bodies will move.
template <class R>
inline Facing<R> facing_before(const Solid<scalar_t<R>>& solid, const Vec3<R>& x, const Vec3<R>& normal,
                               const Vec3<R>& v, const R& dt) {
  return solid.body >= 0 ? flat(normal) : facing(solid, x, normal, v - solid.velocity_at(x), dt);
}

// The six numbers of one body.
template <class T>
inline Vec3<T> linear(const double* u) {
  return {T(u[0]), T(u[1]), T(u[2])};
}
template <class T>
inline Vec3<T> angular(const double* u) {
  return {T(u[3]), T(u[4]), T(u[5])};
}

// The velocity of a solid's surface at `arm` from its centre, where its unit normal is n, if bodies move with U.
template <class R>
inline Vec3<R> surface_velocity(const Solid<scalar_t<R>>& solid, const double* U, const Vec3<R>& arm,
                                const Vec3<R>& n) {
  using T = scalar_t<R>;
  const double* u = solid.body < 0 ? nullptr : U + 6 * solid.body;
  const Vec3<T> V = u ? linear<T>(u) : solid.velocity, w = u ? angular<T>(u) : solid.omega;
  return spread<R>(V) + cross(spread<R>(w), arm) + solid.belt_along(n);
}

// Add what masses m do to a body that has changed their velocity from `before` to `after`; `play`: before.
template <class R, class M>
inline void add_response(BodyResponse& sum, const Solid<scalar_t<R>>& body, const M& inside, const R& m,
                         const Vec3<R>& normal, const Vec3<R>& arm, const Play<R>& play, const Vec3<R>& v_co,
                         const Vec3<R>& before, const Vec3<R>& after) {
  using detail::at_lane;
  const Mat3<R> D = contact_slope(before, normal, v_co, body.mode, body.mu_c, play);
  for (int l = 0; l < width<R>; ++l) {
    if (!at_lane(inside, l)) continue;
    double from_centre[3], dv[3], slope[3][3];
    for (int i = 0; i < 3; ++i) {
      from_centre[i] = double(at_lane(arm[i], l));
      dv[i] = double(at_lane(after[i], l)) - double(at_lane(before[i], l));
      for (int j = 0; j < 3; ++j) slope[i][j] = double(at_lane(D(i, j), l));
    }
    sum.add(double(at_lane(m, l)), from_centre, dv, slope);
  }
}

}  // namespace neve
