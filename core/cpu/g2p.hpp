// Grid to particles: the driver of steps 7 to 10 (Stomakhin et al. 2013, section 4.1) and of the stress for the next step.
// What happens to a particle is mpm/particle_update.hpp; here packs of particles are gathered, loaded and stored.
#pragma once

#include "cpu/grid/gather.hpp"
#include "cpu/lift.hpp"
#include "cpu/material.hpp"
#include "cpu/near.hpp"
#include "cpu/sleep.hpp"
#include "heat/sintering.hpp"
#include "mpm/particle_report.hpp"
#include "threads.hpp"

namespace neve {

namespace detail {

template <class T, class Spline, class Transfer>
class HomeGather {
  using R = Lanes<T>;
  using Weights = StoredWeights<typename Transfer::GatherWeights, Transfer::modes>;
  static constexpr int L = width<R>;

 public:
  HomeGather(const Model<T>& model, const SolidBalls<T>& balls, State<T>& state, Grid<T>& grid, std::size_t h,
             double dt, bool commit)
      : model_(model),
        state_(state),
        home_(grid.homes[h]),
        exchange_(commit ? &grid.particle_exchange[h] : nullptr),
        drift_(commit && model.sleeps() ? &grid.drift[h] : nullptr),
        sinters_(model.heat && model.heat->sinters),
        snow_(only_snow(model, state, home_.begin, home_.count)),
        step_(StepConstants<T>::template of<Spline>(model.dx, dt, model.alpha(dt))),
        frame_(TileFrame<T>::template of<Spline>(model.dx, grid.homes[h].at)),
        from_(tile_),
        from_change_(change_) {
    if (exchange_) exchange_->clear();
    tile_.load_from(grid, home_, &Grid<T>::node);
    if constexpr (Transfer::has_change) change_.load_from(grid, home_, &Grid<T>::node_change);
    solids_ = solids_near_home<T, Spline>(model, balls, home_.at, dt);
    if (state.has_heat()) to_water_ = smooth(solids_);
  }

  Report run() {
    std::uint32_t done = 0;
    for (; done + L <= home_.count; done += L) advance_pack(home_.begin + done, Whole{});
    if (done < home_.count) advance_pack(home_.begin + done, static_cast<int>(home_.count - done));
    Report r = extremes_.report();
    r.drifted = drifted_;
    if (drift_) *drift_ = std::sqrt(max_lane(drift2_));
    r.offending_id = offending_id_;
    return r;
  }

 private:
  // How many particles a pack has: all of its lanes, known to the compiler, or an int.
  using Whole = std::integral_constant<int, L>;

  // The particles of a pack, as values.
  template <class Count>
  struct Pack {
    const State<T>& state;
    std::size_t p;
    Count count;
    Vec3<R> way;  // from the tile's first node, as the near solids know it [m]

    const Vec3<R>& x() const { return way; }
    Vec3<R> v() const { return load_vector<R>(state.v, p, count); }
    Mat3<R> C() const { return load_matrix<R>(state.C, p, count); }
    Mat3<R> F_E() const { return load_matrix<R>(state.F_E, p, count); }
    R J_P() const { return load<R>(state.J_P.column(0) + p, count); }
    R m() const { return load<R>(state.m.column(0) + p, count); }
    R V0() const { return load<R>(state.V0.column(0) + p, count); }
  };

  template <class Count>
  NEVE_INLINE void advance_pack(std::size_t p, Count count) {
    const Pack<Count> pack{state_, p, count, load_way<R>(state_, frame_, p, count)};
    stencils_.template fill<Weights>(frame_, pack.way);
    if ((p - home_.begin) % line_particles<T> == 0) fetch_ahead(p + lines_ahead * line_particles<T>);
    gather(count);
    Advanced<R> now = advance<Transfer>(
        pack, gathered(), step_, is_water(p, count) ? to_water_ : solids_,
        [&](const Mat3<R>& F_trial, const R& J_P) NEVE_INLINE_LAMBDA {
          const Mapped<R> now = return_map(model_, state_, p, count, snow_, F_trial, J_P);
          if (sinters_) flowed_ = distance(F_trial, now.F_E);
          return now;
        },
        [&](const auto& solid, const auto& met, const auto&... exchanged) {
          if (exchange_) record(exchange_->of(solid.index), met, pack.m(), exchanged...);
        });
    const R J = determinant(now.material.F_E) * now.material.J_P;
    const R room = ice_room(model_, state_, p, count, J);
    extremes_.ice_room = min(room, extremes_.ice_room);
    press(p, count, J, any(near_ice(room)), now);
    check(pack, now);
    if (exchange_) keep(p, count, now);
  }

  // Add the stress of ice and of water, which few packs have. (What is handed to a function by reference lies in memory: that is
  // a copy here, so that the rest stays in registers.)
  NEVE_INLINE void press(std::size_t p, int count, const R& J, bool near_ice, Advanced<R>& now) const {
    if (!near_ice && !state_.has_heat()) return;
    Stress<R> stress = now.material.stress;
    if (near_ice) add_ice(model_, state_, p, count, J, step_.cells.dx / step_.dt, stress);
    if (state_.has_heat()) add_water(model_, state_, p, count, J, stress);
    now.material.stress = stress;
  }

  // Whether all particles of a pack are water.
  bool is_water(std::size_t p, int count) const {
    if (!state_.has_heat()) return false;
    const T* f = state_.thermal.column(0) + p;
    return std::all_of(f, f + count, [](T share) { return share >= T(1); });
  }

  static R distance(const Mat3<R>& a, const Mat3<R>& b) {
    const Vec3<R> x = a.c0 - b.c0, y = a.c1 - b.c1, z = a.c2 - b.c2;
    return sqrt(dot(x, x) + dot(y, y) + dot(z, z));
  }

  void fetch_ahead(std::size_t p) const {
    prefetch<Access::write>(state_.x, p), prefetch<Access::write>(state_.v, p);
    prefetch<Access::write>(state_.F_E, p), prefetch<Access::write>(state_.tau, p);
    prefetch<Access::write>(state_.J_P, p), prefetch<Access::read>(state_.m, p);
    prefetch<Access::read>(state_.V0, p), prefetch<Access::read>(state_.stiffness, p);
    prefetch<Access::read>(state_.strength, p);
    if constexpr (Transfer::keeps_C) prefetch<Access::write>(state_.C, p);
    prefetch<Access::write>(state_.modes, p), prefetch<Access::write>(state_.rest, p);
    prefetch<Access::write>(state_.beyond, p);
  }

  void gather(int count) {
    if constexpr (Transfer::modes > 4) {
      for (int l = 0; l < count; ++l) from_.modes(stencils_, l, sums_);
    } else {
      from_.affine(stencils_, count, sums_);
    }
    if constexpr (Transfer::has_affine_change) {
      from_change_.affine(stencils_, count, sums_ + Transfer::modes);
    } else if constexpr (Transfer::has_change) {
      for (int l = 0; l < count; ++l)
        store_quad<T>(sums_[Transfer::modes] + 4 * l, from_change_.sum(stencils_, l), 0);
    }
  }

  Vec3<R> vector_sum(int n) const {
    Vec3<R> a;
    R unused;
    load_quads(sums_[n], a.x, a.y, a.z, unused);
    return a;
  }
  // sum g u^T, of which `n` is the first of three sums; sum w u^T = v.
  Mat3<R> matrix_sum(int n, const Vec3<R>& v) const {
    Mat3<R> G{vector_sum(n), vector_sum(n + 1), vector_sum(n + 2)};
    if constexpr (Weights::count == 1) {
      for (int a = 0; a < 3; ++a) G.column(a) = G.column(a) + v * stencils_.shift[a];
    }
    return G;
  }
  Gathered<R> gathered() const {
    Gathered<R> g{vector_sum(0), {}};
    g.G = matrix_sum(1, g.v);
    constexpr int n = Transfer::modes;
    if constexpr (Transfer::has_change) g.change = vector_sum(n);
    if constexpr (Transfer::has_affine_change) g.G_change = matrix_sum(n + 1, g.change);
    return g;
  }

  // Store what a step has made of a pack.
  template <class Count>
  NEVE_INLINE void keep(std::size_t p, Count count, const Advanced<R>& now) {
    store_way(state_, frame_, p, now.x, count);
    store_vector(state_.v, p, now.v, count);
    store_matrix(state_.F_E, p, now.material.F_E, count);
    store(state_.J_P.column(0) + p, now.material.J_P, count);
    store_symmetric(state_.tau, p, now.material.stress.tau, count);
    if constexpr (Transfer::keeps_C) store_matrix(state_.C, p, now.C, count);
    if (model_.sleeps()) keep_rest(p, count, now);
    if (sinters_) break_sintered(p, count);
    if constexpr (Transfer::modes > 4) keep_modes(p, count, now.x - now.displacement, now.x);
  }

  // What has sintered breaks as the snow flows.
  void break_sintered(std::size_t p, int count) {
    const R one = splat<R>(1), grown = load<R>(state_.thermal.column(1) + p, count);
    const R left = max(R(one - flowed_ * T(1 / sintering::breaking)), splat<R>(0));
    store(state_.thermal.column(1) + p, R(one + (grown - one) * left), count);
  }

  // How long the particles have rested: how long their mean velocity over the time after which snow sleeps has been small.
  // What only swings about its place rests.
  void keep_rest(std::size_t p, int count, const Advanced<R>& now) {
    const T share = T(step_.dt / std::max(model_.sleep_after, double(step_.dt)));
    const T slow2 = T(model_.sleep_speed * model_.sleep_speed);
    const Vec3<R> before = load_vector<R>(state_.rest, p, count, 1);
    const Vec3<R> mean = before + (now.v - before) * splat<R>(share);
    const R mean2 = dot(mean, mean), time = load<R>(state_.rest.column(0) + p, count) + T(step_.dt);
    store(state_.rest.column(0) + p, select(mean2 < slow2, time, R{}), count);
    store_vector(state_.rest, p, mean, count, 1);
    drift2_ = max(drift2_, select(first_lanes<R>(count), mean2, R{}));
  }

  // The further modes from their sums, as the particle takes them along.
  void keep_modes(std::size_t p, int count, const Vec3<R>& from, const Vec3<R>& to) {
    Vec3<R> kept;
    if constexpr (Transfer::squares) {
      for (int a = 0; a < 3; ++a)
        kept[a] = Transfer::template kept<Spline>(fraction(from[a]), fraction(to[a]));
    }
    for (int n = 4; n < Transfer::modes; ++n) {
      const Vec3<R> c = Transfer::template coefficient<Spline>(n, vector_sum(n), kept);
      store_vector(state_.modes, p, c, count, 3 * (n - 4));
    }
  }
  R fraction(R way) const {
    const R u = frame_.local(way);
    return u - floor(u);
  }

  template <class Count>
  NEVE_INLINE void check(const Pack<Count>& pack, const Advanced<R>& now) {
    const auto here = first_lanes<R>(pack.count);
    const R bad = extremes_.add_step(here, now, pack.m(), pack.V0(), step_);
    if (any(bad > R{})) find_offender(pack, bad);
    for (int a = 0; a < 3; ++a) {
      const R u = frame_.local(now.x[a]);
      drifted_ = drifted_ || any(here & ((u < T(0)) | (u >= T(Spline::reach))));
    }
  }

  template <class P>
  NEVE_RARE void find_offender(const P& pack, R bad) {
    for (int l = 0; l < pack.count; ++l) {
      if (bad[l] > T(0))
        offending_id_ = std::min(offending_id_, state_.id[pack.p + static_cast<std::size_t>(l)]);
    }
  }

  const Model<T>& model_;
  State<T>& state_;
  const Home& home_;
  ExchangeSum* exchange_;  // none: a trial, which moves nothing
  T* drift_;               // the largest mean velocity of the home's particles, where snow may sleep
  bool sinters_;
  const Snow* snow_;  // of all particles of the home, if they are of one
  StepConstants<T> step_;
  TileFrame<T> frame_;
  Tile<T> tile_, change_;
  Gather<T, Spline> from_, from_change_;
  std::vector<NearSolid<T>> solids_, to_water_;
  Stencils<T, Spline, Weights::count> stencils_;
  Extremes<R> extremes_;
  R drift2_{}, flowed_{};
  bool drifted_ = false;
  std::uint32_t offending_id_ = Report::nobody;
  alignas(64) T sums_[Transfer::modes + Transfer::has_change + 3 * Transfer::has_affine_change]
                     [4 * L];  // of each mode; then of the change
};

// Add what snow and solids exchanged in a step to the sums since they were last taken, or to the ledger of a rank.
template <class T>
void add_up_exchange(const Model<T>& model, Grid<T>& grid) {
  if (grid.halo.shares) {
    for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
      if (grid.halo.counted[b]) enter(grid.halo, key_of(grid.blocks[b]), 0, grid.node_exchange[b]);
    }
    for (std::size_t h = 0; h < grid.moving; ++h)
      enter(grid.halo, key_of(grid.homes[h].at), 1, grid.particle_exchange[h]);
    ++grid.halo.step;
    return;
  }
  grid.exchanged.resize(model.solids.size());
  for (const ExchangeSum& sum : grid.node_exchange) sum.add_to(grid.exchanged);
  for (const ExchangeSum& sum : grid.particle_exchange) sum.add_to(grid.exchanged);
}

}  // namespace detail

// Move the particles by one step; with `commit` false, only report what the step would do to them.
template <class T, class Spline, class Transfer>
Report g2p(const Model<T>& model, State<T>& state, Grid<T>& grid, double dt, bool commit) {
  if (commit && grid.has_lift) gather_lift<T, Spline>(model, state, grid);
  const SolidBalls<T> balls(model);
  Report r = merge_each<Report>(grid.moving, [&](std::size_t h) {
    return detail::HomeGather<T, Spline, Transfer>(model, balls, state, grid, h, dt, commit).run();
  });
  // Snow that sleeps may be the stiffest; within an advance the limits only grow tighter.
  if (model.sleeps()) {
    r.wave = std::max(r.wave, grid.rest_wave), r.fastest = std::max(r.fastest, grid.rest_wave);
    r.ice_room = std::min(r.ice_room, grid.rest_room);
  }
  if (!commit) return r;
  if (model.sleeps()) grid.rest_wave = r.wave, grid.rest_room = r.ice_room;
  stir(model, state, grid);
  if (r.drifted) grid.current = false;
  if (!model.solids.empty()) detail::add_up_exchange(model, grid);
  return r;
}

}  // namespace neve
