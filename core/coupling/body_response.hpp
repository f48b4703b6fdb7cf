// One contact of snow with a body whose velocity is not known yet: what each does to the other, for any velocities of the
// bodies. The bodies' velocities U are six numbers each: velocity [m/s], angular velocity [rad/s].
#pragma once

#include "coupling/contacts.hpp"
#include "coupling/exchange.hpp"
#if !defined(__CUDACC_RTC__)
#include "coupling/doubles.hpp"
#endif

namespace neve {

// What the snow does to one body: impulse and moment about its centre, and how fast they fall as the body moves. N: a number,
// or a pack of them, whose lanes are summed in the end.
template <class N>
struct ResponseOf {
  N impulse[6] = {}, slope[36] = {};

  void add(const ResponseOf& o) {
    for (int k = 0; k < 6; ++k) impulse[k] += o.impulse[k];
    for (int k = 0; k < 36; ++k) slope[k] += o.slope[k];
  }

  // Add one node: mass m gets dv, and v' changes by D when the surface's velocity does, at `arm` from the centre.
  //
  // The surface moves with v_co = V + omega x arm = V + X omega: the parts of the slope are m D, m D X, and X^T times
  // these.
  void add(const N& m, const Vec3<N>& arm, const Vec3<N>& dv, const Mat3<N>& D) {
    const Vec3<N> p = dv * m, moment = cross(arm, p);
    for (int k = 0; k < 3; ++k) impulse[k] = impulse[k] - p[k], impulse[3 + k] = impulse[3 + k] - moment[k];
    for (int i = 0; i < 3; ++i) {
      const Vec3<N> row{m * D(i, 0), m * D(i, 1), m * D(i, 2)};
      const Vec3<N> turned = cross(arm, row);  // the row times X
      for (int j = 0; j < 3; ++j) {
        slope[6 * i + j] += row[j];
        slope[6 * i + 3 + j] += turned[j];
      }
      // X^T: this row counts in the other two
      const int next = (i + 1) % 3, last = (i + 2) % 3;
      const N a = arm[last], b = arm[next];
      for (int j = 0; j < 3; ++j) {
        slope[6 * (3 + next) + j] += a * row[j];
        slope[6 * (3 + next) + 3 + j] += a * turned[j];
        slope[6 * (3 + last) + j] = slope[6 * (3 + last) + j] - b * row[j];
        slope[6 * (3 + last) + 3 + j] = slope[6 * (3 + last) + 3 + j] - b * turned[j];
      }
    }
  }
};
using BodyResponse = ResponseOf<double>;

// Where a surface faces snow at x that moves with v, as long as it is not known how bodies will move.
template <class R, class M>
inline Facing<R> facing_before(const Solid<scalar_t<R>>& solid, const Vec3<R>& x, const Vec3<R>& normal,
                               const Vec3<R>& v, const R& dt, const M& wanted) {
  return solid.body >= 0 ? flat(normal) : facing(solid, x, normal, v - solid.velocity_at(x), dt, wanted);
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
inline void add_response(ResponseOf<Doubles<R>>& sum, const Solid<scalar_t<R>>& body, const M& inside,
                         const R& m, const Vec3<R>& normal, const Vec3<R>& arm, const Play<R>& play,
                         const Vec3<R>& v_co, const Vec3<R>& before, const Vec3<R>& after) {
  using N = Doubles<R>;
  const Mat3<R> D = contact_slope(before, normal, v_co, body.mode, body.mu_c, play);
  const auto wide = [](const Vec3<R>& a) { return Vec3<N>{doubles(a.x), doubles(a.y), doubles(a.z)}; };
  // what does not meet the body may have no numbers at all
  const auto met = [&](const Vec3<R>& a) { return wide(select(inside, a, Vec3<R>{})); };
  sum.add(doubles(select(inside, m, R{})), met(arm), met(after) - met(before),
          {met(D.c0), met(D.c1), met(D.c2)});
}

}  // namespace neve
