// One contact of snow with a body whose velocity is not known yet: what each does to the other, for any velocities of the
// bodies. The bodies' velocities U are six numbers each: velocity [m/s], angular velocity [rad/s].
#pragma once

#include "coupling/contacts.hpp"
#include "coupling/exchange.hpp"
#if !defined(__CUDACC_RTC__)
#include "coupling/doubles.hpp"
#endif

namespace neve {

// What the snow does to one body: impulse and moment about its centre. N: a number, or a pack of them, whose lanes are
// summed in the end.
template <class N>
struct ImpulseOf {
  N impulse[6] = {};

  void add(const ImpulseOf& o) {
    for (int k = 0; k < 6; ++k) impulse[k] += o.impulse[k];
  }
  // Add one node: mass m gets dv, at `arm` from the centre.
  void add(const N& m, const Vec3<N>& arm, const Vec3<N>& dv) {
    const Vec3<N> p = dv * m, moment = cross(arm, p);
    for (int k = 0; k < 3; ++k) impulse[k] = impulse[k] - p[k], impulse[3 + k] = impulse[3 + k] - moment[k];
  }
};

// How fast impulse and moment fall as the body moves.
template <class N>
struct SlopeOf {
  N slope[36] = {};

  void add(const SlopeOf& o) {
    for (int k = 0; k < 36; ++k) slope[k] += o.slope[k];
  }
  // Add one node: the velocity of its mass m changes by D when the surface's does, at `arm` from the centre.
  //
  // The surface moves with v_co = V + omega x arm = V + X omega: the parts of the slope are m D, m D X, and X^T times
  // these.
  void add(const N& m, const Vec3<N>& arm, const Mat3<N>& D) {
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

template <class N>
struct ResponseOf : ImpulseOf<N>, SlopeOf<N> {
  void add(const ResponseOf& o) { ImpulseOf<N>::add(o), SlopeOf<N>::add(o); }
  void add(const N& m, const Vec3<N>& arm, const Vec3<N>& dv, const Mat3<N>& D) {
    ImpulseOf<N>::add(m, arm, dv), SlopeOf<N>::add(m, arm, D);
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

// In double precision, for the lanes `met`; what does not meet the body may have no numbers at all.
template <class R, class M>
inline Vec3<Doubles<R>> doubles_of(const Vec3<R>& a, const M& met) {
  const Vec3<R> only = select(met, a, Vec3<R>{});
  return {doubles(only.x), doubles(only.y), doubles(only.z)};
}

// Add the impulse that masses m give a body that has changed their velocity from `before` to `after`.
template <class R, class M>
inline void add_impulse(ImpulseOf<Doubles<R>>& sum, const M& inside, const R& m, const Vec3<R>& arm,
                        const Vec3<R>& before, const Vec3<R>& after) {
  sum.add(doubles(select(inside, m, R{})), doubles_of(arm, inside),
          doubles_of(after, inside) - doubles_of(before, inside));
}

// Add how that falls as the body moves; `play`: before. It need be no more precise than the velocities.
template <class R, class M>
inline void add_slope(SlopeOf<R>& sum, const Solid<scalar_t<R>>& body, const M& inside, const R& m,
                      const Vec3<R>& normal, const Vec3<R>& arm, const Play<R>& play, const Vec3<R>& v_co,
                      const Vec3<R>& before) {
  const Mat3<R> D = contact_slope(before, normal, v_co, body.mode, body.mu_c, play);
  const auto met = [&](const Vec3<R>& a) { return select(inside, a, Vec3<R>{}); };
  sum.add(select(inside, m, R{}), met(arm), {met(D.c0), met(D.c1), met(D.c2)});
}

// Add what masses m do to a body that has changed their velocity from `before` to `after`; `play`: before.
template <class R, class M>
inline void add_response(ResponseOf<Doubles<R>>& sum, const Solid<scalar_t<R>>& body, const M& inside,
                         const R& m, const Vec3<R>& normal, const Vec3<R>& arm, const Play<R>& play,
                         const Vec3<R>& v_co, const Vec3<R>& before, const Vec3<R>& after) {
  const Mat3<R> D = contact_slope(before, normal, v_co, body.mode, body.mu_c, play);
  const auto met = [&](const Vec3<R>& a) { return doubles_of(a, inside); };
  sum.add(doubles(select(inside, m, R{})), met(arm), met(after) - met(before),
          {met(D.c0), met(D.c1), met(D.c2)});
}

}  // namespace neve
