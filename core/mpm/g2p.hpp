// Grid to particles: deformation, plastic flow, hardening, velocities, particle collisions, positions
// (Stomakhin et al. 2013, section 4.1, steps 7 to 10), and the stress for the next step.
#pragma once

#include "coupling/swept_contact.hpp"
#include "mpm/grid_update.hpp"
#include "mpm/material.hpp"
#include "mpm/report.hpp"
#include "mpm/transfer/weights.hpp"

namespace neve {

namespace detail {

// What packs of particles report, kept lane by lane until the end of a home.
template <class R>
struct Extremes {
  using T = scalar_t<R>;
  R wave{}, speed{}, fastest{}, rate2{}, compression{}, displacement2{}, min_volume_ratio = splat<R>(1);
  bool finite = true;

  // `sum` gathers all numbers of a particle: it is finite only if they all are.
  void add(const State<T>& state, std::size_t p, int count, const Vec3<R>& v, R modulus,
           const Mat3<R>& grad_v, R sum) {
    const auto here = first_lanes<R>(count);
    const R m = load<R>(state.m.column(0) + p, count), V0 = load<R>(state.V0.column(0) + p, count);
    const R c = select(here, sqrt(modulus * V0 / select(m > T(0), m, splat<R>(1))), R{});
    const R s = select(here, sqrt(dot(v, v)), R{});
    const R rate = dot(grad_v.c0, grad_v.c0) + dot(grad_v.c1, grad_v.c1) + dot(grad_v.c2, grad_v.c2);
    const R all = select(here, sum + modulus, R{});
    wave = max(c, wave);
    speed = max(s, speed);
    fastest = max(c + s, fastest);
    rate2 = max(select(here, rate, R{}), rate2);
    compression = max(select(here, R(-grad_v.c0.x - grad_v.c1.y - grad_v.c2.z), R{}), compression);
    finite = finite && !any(all - all != R{});
  }
  Report report() const {
    Report r;
    r.wave = static_cast<double>(max_lane(wave));
    r.speed = static_cast<double>(max_lane(speed));
    r.fastest = static_cast<double>(max_lane(fastest));
    r.strain_rate = std::sqrt(static_cast<double>(max_lane(rate2)));
    r.compression_rate = static_cast<double>(max_lane(compression));
    r.max_displacement = std::sqrt(static_cast<double>(max_lane(displacement2)));
    r.min_volume_ratio = -static_cast<double>(max_lane(-min_volume_ratio));
    r.finite = finite;
    return r;
  }
};

template <class R>
R sum_of(const Vec3<R>& a) {
  return a.x + a.y + a.z;
}
template <class R>
R sum_of(const Mat3<R>& a) {
  return sum_of(a.c0 + a.c1 + a.c2);
}

template <class T, class S, class X>
class HomeGather {
  using R = Lanes<T>;
  static constexpr int L = width<R>;

 public:
  HomeGather(const Model<T>& model, State<T>& state, Grid<T>& grid, std::size_t h, double dt, bool commit)
      : model_(model),
        state_(state),
        home_(grid.homes[h]),
        exchange_(commit ? &grid.particle_exchange[h] : nullptr),
        dt_(T(dt)),
        alpha_(model.alpha(dt)),
        frame_(TileFrame<T>::template of<S>(model.dx, grid.homes[h].at)),
        from_(tile_),
        from_change_(change_) {
    if (exchange_) exchange_->clear();
    tile_.load_from(grid, home_, &Grid<T>::node);
    if constexpr (X::has_change) change_.load_from(grid, home_, &Grid<T>::node_change);
    const auto dx = static_cast<T>(model.dx);
    const Vec3<T> corner = node_position(model, home_.at, 0, 0, 0),
                  half{T(3.5) * dx, T(3.5) * dx, T(3.5) * dx};
    solids_ = solids_near(model.solids, corner + half, T(7.1) * dx);
  }

  Report run() {
    for (std::uint32_t done = 0; done < home_.count; done += L) {
      const int count = std::min<int>(L, static_cast<int>(home_.count - done));
      batch(home_.begin + done, count);
    }
    Report r = extremes_.report();
    r.drifted = drifted_;
    r.offending_id = offending_id_;
    return r;
  }

 private:
  void batch(std::size_t p, int count) {
    Vec3<R> x = load_vector<R>(state_.x, p, count);
    stencils_.template fill<typename X::From>(frame_, x);
    gather(count);
    Vec3<R> pic, dv{};
    Mat3<R> G;
    R unused;
    load_quads(sums_[0], pic.x, pic.y, pic.z, unused);
    load_quads(sums_[1], G.c0.x, G.c0.y, G.c0.z, unused);
    load_quads(sums_[2], G.c1.x, G.c1.y, G.c1.z, unused);
    load_quads(sums_[3], G.c2.x, G.c2.y, G.c2.z, unused);
    if constexpr (X::has_change) load_quads(sums_[X::modes], dv.x, dv.y, dv.z, unused);
    const Mat3<R> grad_v = X::template velocity_gradient<S>(G, model_.dx);

    // 7. deformation, plastic flow, hardening; and the stress of the new state
    const Mat3<R> F = load_matrix<R>(state_.F_E, p, count);
    const R J_P = load<R>(state_.J_P.column(0) + p, count);
    const Mat3<R> F_trial = F + scaled(grad_v * F, dt_);
    const Mapped<R> mapped = return_map(model_, state_, p, count, F_trial, J_P);

    // 8. velocities, 9. particle collisions, 10. positions
    Vec3<R> v = X::velocity(load_vector<R>(state_.v, p, count), pic, dv, alpha_);
    const R m = load<R>(state_.m.column(0) + p, count);
    Vec3<R> path = v;
    if constexpr (X::has_path)
      path = X::path(v, pic, determinant(F_trial), held_by_any(solids_, x, T(skin_cells * model_.dx)));
    move_past(solids_, x, v, path, dt_, T(model_.dx), m,
              [&](const auto& solid, const auto& met, const auto&... exchanged) {
                if (exchange_) record(exchange_->of(solid.index), met, m, exchanged...);
              });
    const Vec3<R> way = path * dt_;
    x = x + way;

    check(p, count, x, v, grad_v, way, mapped);
    if (!exchange_) return;
    store_vector(state_.x, p, x, count);
    store_vector(state_.v, p, v, count);
    store_matrix(state_.F_E, p, mapped.F_E, count);
    store(state_.J_P.column(0) + p, mapped.J_P, count);
    store_symmetric(state_.tau, p, mapped.stress.tau, count);
    X::keep(state_, p, count, grad_v);
    if constexpr (X::modes > 4) keep_modes(p, count, x - way, x);
  }

  void gather(int count) {
    for (int l = 0; l < count; ++l) {
      if constexpr (X::modes > 4) {
        from_.modes(stencils_, l, sums_);
      } else {
        const Row<T> s = from_.sums(stencils_, l);
        for (int k = 0; k < 4; ++k) store_quad<T>(sums_[k] + 4 * l, s, k);
      }
    }
    if constexpr (X::has_change) {
      for (int l = 0; l < count; ++l) {
        store_quad<T>(sums_[X::modes] + 4 * l, from_change_.sum(stencils_, l), 0);
      }
    }
  }

  // The further modes from their sums. On its way the particle takes its square modes to where they weigh more or less:
  // where more, they are scaled down, so that moving never adds to their energy.
  void keep_modes(std::size_t p, int count, const Vec3<R>& from, const Vec3<R>& to) {
    R kept[3];
    if constexpr (X::squares) {
      for (int a = 0; a < 3; ++a) {
        const R before = square_norm_at(from[a], a), after = square_norm_at(to[a], a);
        kept[a] = select(after > before, sqrt(before / select(after > R{}, after, splat<R>(1))), splat<R>(1));
      }
    }
    for (int n = 4; n < X::modes; ++n) {
      Vec3<R> c;
      R unused;
      load_quads(sums_[n], c.x, c.y, c.z, unused);
      c = c * T(X::template scale<S>(n));
      if constexpr (X::squares) {
        for (int a = 0; a < 3; ++a) {
          if (X::order[static_cast<std::size_t>(n)].degree[a] == 2) c = c * kept[a];
        }
      }
      store_vector(state_.modes, p, c, count, 3 * (n - 4));
    }
  }
  R square_norm_at(R x, int axis) const {
    const R u = frame_.local(x, axis);
    return square_norm<S>(R(u - floor(u)));
  }

  void check(std::size_t p, int count, const Vec3<R>& x, const Vec3<R>& v, const Mat3<R>& grad_v,
             const Vec3<R>& way, const Mapped<R>& mapped) {
    const auto here = first_lanes<R>(count);
    const R sum = sum_of(x) + sum_of(v) + sum_of(mapped.F_E) + mapped.J_P + mapped.stress.modulus;
    extremes_.add(state_, p, count, v, mapped.stress.modulus, grad_v, sum);
    const R displacement2 = select(here, dot(way, way) * (frame_.inv_dx * frame_.inv_dx), R{});
    const R min_volume_ratio = select(here, determinant(identity<R>() + scaled(grad_v, dt_)), splat<R>(1));
    extremes_.displacement2 = max(displacement2, extremes_.displacement2);
    extremes_.min_volume_ratio = min(min_volume_ratio, extremes_.min_volume_ratio);
    const auto good = (sum - sum == R{}) & (displacement2 <= T(displacement_limit * displacement_limit)) &
                      (min_volume_ratio >= T(volume_ratio_limit));
    const R bad = select(here, select(good, R{}, splat<R>(1)), R{});
    if (any(bad > R{})) find_offender(p, count, bad);
    for (int a = 0; a < 3; ++a) {
      const R u = frame_.local(x[a], a);
      drifted_ = drifted_ || any(here & ((u < T(0)) | (u >= T(S::reach))));
    }
  }

  void find_offender(std::size_t p, int count, R bad) {
    for (int l = 0; l < count; ++l) {
      if (bad[l] > T(0)) offending_id_ = std::min(offending_id_, state_.id[p + static_cast<std::size_t>(l)]);
    }
  }

  const Model<T>& model_;
  State<T>& state_;
  const Home& home_;
  ExchangeSum* exchange_;  // none: a trial, which moves nothing
  T dt_;
  double alpha_;
  TileFrame<T> frame_;
  Tile<T> tile_, change_;
  Gather<T, S> from_, from_change_;
  std::vector<Solid<T>> solids_;
  Stencils<T, S, X::From::count> stencils_;
  Extremes<R> extremes_;
  bool drifted_ = false;
  std::uint32_t offending_id_ = Report::nobody;
  alignas(64) T sums_[X::modes + X::has_change][4 * L];  // of each mode; then of the change
};

}  // namespace detail

// Move the particles by one step; with `commit` false, only report what the step would do to them.
template <class T, class S, class X>
Report g2p(const Model<T>& model, State<T>& state, Grid<T>& grid, double dt, bool commit) {
  const Report r = merge_each<Report>(grid.homes.size(), [&](std::size_t h) {
    return detail::HomeGather<T, S, X>(model, state, grid, h, dt, commit).run();
  });
  if (!commit) return r;
  if (r.drifted) grid.current = false;
  if (!model.solids.empty()) {
    grid.exchanged.resize(model.solids.size());
    for (const ExchangeSum& sum : grid.node_exchange) sum.add_to(grid.exchanged);
    for (const ExchangeSum& sum : grid.particle_exchange) sum.add_to(grid.exchanged);
  }
  return r;
}

}  // namespace neve
