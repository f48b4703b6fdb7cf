// The end of a step: velocities, deformation and positions (Gissler et al. 2020, algorithm 1 and section 3.3.1).
#pragma once

#include "sph/density.hpp"
#include "sph/phases.hpp"
#include "sph/walls.hpp"

namespace neve {

// How far a step may go: way of a particle [m], dt |grad v| [1]; beyond, nothing is moved.
struct SphLimits {
  double way, strain;
};
struct SphReport {
  double speed = 0;        // largest [m/s]
  double strain_rate = 0;  // largest |grad v| [1/s]
  bool finite = true;
  bool taken = false;  // the particles have moved
  void merge(const SphReport& o) {
    speed = std::max(speed, o.speed), strain_rate = std::max(strain_rate, o.strain_rate);
    finite = finite && o.finite;
  }
};

namespace detail {

// The rotation that the spin of D makes in dt, exactly orthogonal (Cayley's transform), on a matrix from the left.
template <class R>
struct Turn {
  Vec3<R> k;
  R factor;

  Turn(const Mat3<R>& D, scalar_t<R> dt) {
    const scalar_t<R> quarter = dt * scalar_t<R>(0.25);  // half of dt times half of the difference
    k = {R(D(2, 1) - D(1, 2)) * quarter, R(D(0, 2) - D(2, 0)) * quarter, R(D(1, 0) - D(0, 1)) * quarter};
    factor = splat<R>(2) / (splat<R>(1) + dot(k, k));
  }
  Vec3<R> of(const Vec3<R>& u) const {
    const Vec3<R> once = cross(k, u);
    return u + (once + cross(k, once)) * factor;
  }
  Mat3<R> of(const Mat3<R>& a) const { return {of(a.c0), of(a.c1), of(a.c2)}; }
};

}  // namespace detail

// The elastic deformation after a step: with S and W the symmetric and the skew part of D, and Q the rotation by dt W,
//
//   (1 + dt S) F = U diag(s) V^T,   F <- Q U diag(clamp(s, 1 - theta_c, 1 + theta_s)) U^T Q^T.
//
// The stretch of the snow in the axes of the world; a rigid rotation turns it and makes none.
template <class R>
Mat3<R> deformed(const Mat3<R>& F, const Mat3<R>& D, scalar_t<R> dt, const R& theta_c, const R& theta_s) {
  using T = scalar_t<R>;
  Mat3<R> grown = identity<R>();
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) grown(r, c) = grown(r, c) + (D(r, c) + D(c, r)) * (dt * T(0.5));
  }
  const auto A = svd3(grown * F);
  const detail::Turn<R> turn(D, dt);
  const Mat3<R> U = turn.of(A.U);
  Vec3<R> e;
  for (int k = 0; k < 3; ++k) e[k] = clamp(A.strain[k], R(-theta_c), theta_s);
  Mat3<R> out = identity<R>();
  for (int k = 0; k < 3; ++k) {
    const Vec3<R>& u = U.column(k);
    for (int c = 0; c < 3; ++c) out.column(c) = out.column(c) + u * R(u[c] * e[k]);
  }
  return out;
}

// Move the snow by dt [s] with the accelerations in `sums`, unless that would be too far; `exchanged` gets what snow and
// solids gave each other.
template <class T>
class SphAdvance {
 public:
  using R = Lanes<T>;
  // spacing: distance of particles [m].
  SphAdvance(const Model<T>& world, SphState<T>& s, const SphBoundary<T>& walls, const SphPairs<T>& snow,
             const SphPairs<T>& boundary, const SphFriction<T>& friction, SphSums<T>& sums, T spacing,
             double dt)
      : world_(world),
        s_(s),
        walls_(walls),
        snow_(snow),
        boundary_(boundary),
        friction_(friction),
        sums_(sums),
        contacts_(world, spacing / 2, T(dt)),
        dt_(dt) {}

  SphReport operator()(const SphLimits& limits, std::vector<Exchange>& exchanged) {
    const std::size_t n = s_.count, chunks = (n + chunk - 1) / chunk;
    v_.resize(n), out_.resize(n), D_.resize(n);
    std::vector<Part> parts(chunks);
    each_index(chunks, [&](std::size_t c) { find_velocities(c, parts[c]); });
    meet_bodies(parts);
    find_gradients();
    SphReport report = merge_each<SphReport>(chunks, [&](std::size_t c) { return look(c); });
    report.taken =
        report.finite && report.speed * dt_ <= limits.way && report.strain_rate * dt_ <= limits.strain;
    if (!report.taken) return report;
    each_index(chunks, [&](std::size_t c) { move(c); });
    exchanged.resize(world_.solids.size());
    for (const Part& part : parts) part.exchange.add_to(exchanged);
    return report;
  }

 private:
  static constexpr std::size_t chunk = 16 * std::size_t(width<R>);
  std::size_t end(std::size_t c) const { return std::min(s_.count, (c + 1) * chunk); }
  template <class F>
  void packs(std::size_t c, F&& f) const {
    for (std::size_t p = c * chunk; p < end(c); p += width<R>)
      f(p, int(std::min<std::size_t>(width<R>, end(c) - p)));
  }

  // What a chunk gave solids, and its particles that may meet bodies.
  struct Part {
    ExchangeSum exchange;
    BodyContacts<T> waiting;
  };

  Vec3<R> acceleration(std::size_t p, int count) const {
    return load_vector<R>(sums_.given, p, count) + load_vector<R>(sums_.pressed, p, count) +
           load_vector<R>(sums_.sheared, p, count);
  }

  // v + dt (given + pressed + sheared), and nowhere into a collider.
  void find_velocities(std::size_t c, Part& part) {
    for (std::size_t p = c * chunk; p < end(c); ++p)
      record_walls(world_, s_, walls_, boundary_, friction_, sums_, p, dt_, part.exchange);
    packs(c, [&](std::size_t p, int count) {
      const R zero = splat<R>(0), m = load<R>(s_.m.column(0) + p, count);
      const Vec3<R> a = acceleration(p, count);
      ContactPack<T> pack{p,
                          count,
                          load_vector<R>(s_.x, p, count),
                          load_vector<R>(s_.v, p, count) + a * T(dt_),
                          {zero, zero, zero},
                          zero,
                          m,
                          0,
                          0};
      if (world_.solids.empty() || !contacts_.act(pack, a * m, part.exchange, part.waiting)) keep(pack);
    });
  }
  void keep(const ContactPack<T>& pack) {
    store_vector(v_, pack.p, pack.v, pack.count), store_vector(out_, pack.p, pack.out, pack.count);
  }

  // Let the bodies act on those that have waited, with velocities that are found with theirs.
  void meet_bodies(std::vector<Part>& parts) {
    std::vector<const BodyContacts<T>*> waiting;
    for (const Part& part : parts) {
      if (!part.waiting.packs.empty()) waiting.push_back(&part.waiting);
    }
    if (waiting.empty()) return;
    std::vector<Exchange> given(world_.solids.size());
    for (const Part& part : parts) part.exchange.add_to(given);
    const CoupledBodies bodies = pushed(world_, given);
    const std::vector<Twist> U = body_velocities(bodies, waiting, dt_);
    each_index(parts.size(), [&](std::size_t c) {
      for (ContactPack<T>& pack : parts[c].waiting.packs) {
        contacts_.finish(parts[c].waiting, pack, U, acceleration(pack.p, pack.count) * pack.m,
                         parts[c].exchange);
        keep(pack);
      }
    });
  }

  void find_gradients() {
    const auto v = [&](std::size_t p, int count) { return load_vector<R>(v_, p, count); };
    detail::fill_quads(s_.count, sums_, v);
    find_across(s_, snow_, sums_, v);
    const auto beside = [&](std::size_t p, int count) {
      return load<R>(sums_.inflow.column(0) + p, count) + load<R>(sums_.across.column(0) + p, count);
    };
    each_gradient(snow_, sums_, s_.count, sums_.walls, v, beside,
                  [&](std::size_t p, int count, const Mat3<R>& D) { store_matrix(D_, p, D, count); });
    if (!s_.has_water()) return;
    each_row(s_.count, [&](std::size_t p) {  // which keeps no deformation
      if (s_.is_water(p)) set_matrix(D_, p, Mat3<T>{});
    });
  }

  SphReport look(std::size_t c) const {
    SphReport report;
    for (std::size_t p = c * chunk; p < end(c); ++p) {
      const Vec3<T> v = vector_at(v_, p);
      const Mat3<T> D = matrix_at(D_, p);
      const double speed2 = double(dot(v, v)),
                   rate2 = double(dot(D.c0, D.c0) + dot(D.c1, D.c1) + dot(D.c2, D.c2));
      report.finite = report.finite && std::isfinite(speed2 + rate2);
      report.speed = std::max(report.speed, std::sqrt(speed2));
      report.strain_rate = std::max(report.strain_rate, std::sqrt(rate2));
    }
    return report;
  }

  void move(std::size_t c) {
    packs(c, [&](std::size_t p, int count) {
      R theta_c = splat<R>(0), theta_s = splat<R>(0);
      for (int l = 0; l < count; ++l) {
        const auto q = detail::constants_at(world_, s_, p + std::size_t(l));
        theta_c[l] = q.theta_c, theta_s[l] = q.theta_s;
      }
      const Mat3<R> F = select(first_lanes<R>(count), load_matrix<R>(s_.F_E, p, count), identity<R>());
      store_matrix(s_.F_E, p, deformed(F, load_matrix<R>(D_, p, count), T(dt_), theta_c, theta_s), count);
      const Vec3<R> v = load_vector<R>(v_, p, count);
      const Vec3<R> x = load_vector<R>(s_.x, p, count) + v * T(dt_) + load_vector<R>(out_, p, count);
      store_vector(s_.v, p, v, count), store_vector(s_.x, p, x, count);
      store(s_.p_last.column(0) + p, load<R>(sums_.p.column(0) + p, count), count);
      store_vector(s_.a_last, p, load_vector<R>(sums_.sheared, p, count), count);
    });
  }

  const Model<T>& world_;
  SphState<T>& s_;
  const SphBoundary<T>& walls_;
  const SphPairs<T>&snow_, &boundary_;
  const SphFriction<T>& friction_;
  SphSums<T>& sums_;
  const PointContacts<T> contacts_;
  double dt_;
  Field<T, 3> v_, out_;
  Field<T, 9> D_;
};

}  // namespace neve
