// The implicit solve for pressure where there is water.
//
// One system for snow and water, of either side of their surface. Its gradients are divided by the density before their
// divergence is taken, as the acceleration is: across the surface the density jumps.
//
//   -(rho_0 / lam) p + dt^2 rho div (grad p / rho) = rho_0 - rho*,
//   grad p_i = sum_j V_j (p_i + p_j) grad W_ij + sum_k V_k (max(p_i, 0) + max(p_k, 0)) grad W_ik + walls,
//
// j over the own phase, k over the other: snow holds water by no tension. Water has no tension at all, p >= 0 and the
// system an inequality where p = 0; its rho_0 - rho* is that of what fills its kernel. Bodies give way to the pressures.
#pragma once

#include "sph/phases.hpp"
#include "sph/water/floating.hpp"
#include "sph/water/viscosity.hpp"

namespace neve {

// How fast water whose kernel is overfilled is pushed apart, over the overfill: our choice [m/s]. Pushed apart within one
// step it would move by that way over dt, and boil.
inline constexpr double restoring_speed = 1;

// Of a lattice that ends in a plane, at its last layer: what is missing of the fill, and the gradient of the fill times the
// distance of particles [1]; and how much of such a gradient there is in water that is out of order, by our choice.
inline constexpr double surface_gap = 0.1497, surface_slope = 0.51, disorder = 0.2;

namespace detail {

template <class T>
class MixtureSolve {
 public:
  using R = Lanes<T>;
  MixtureSolve(const CubicKernel<T>& kernel, const SphState<T>& s, const SphPairs<T>& pairs,
               Floating<T>& bodies, double dt, SphSums<T>& sums)
      : s_(s),
        pairs_(pairs),
        bodies_(bodies),
        dt_(T(dt)),
        spacing_(kernel.h / 2),
        restored_(std::min(T(1), dt_ * T(restoring_speed) / (kernel.h / 2))),
        sums_(sums),
        n_(s.count) {
    missing_.resize(n_), diagonal_.resize(n_);
    Vp_.resize(n_ + 64), Vp_pressing_.resize(n_ + 64);
  }

  // The right-hand side, of velocities with the acceleration `dragged`, and the diagonal.
  void start(const Vectors<T>& dragged) {
    const auto v = [&](std::size_t p, int count) {
      return load_vector<R>(s_.v, p, count) +
             (load_vector<R>(sums_.given, p, count) + load_vector<R>(dragged, p, count)) * dt_;
    };
    fill_quads(n_, sums_, v);
    each_row(n_, [&](std::size_t p) {
      const Vec3<T> here = vector_at(s_.v, p) + (vector_at(sums_.given, p) + vector_at(dragged, p)) * dt_;
      const T over = rest(p) - now(p);
      missing_[p] = (s_.is_water(p) && over < T(0) ? over * restored_ : over) +
                    dt_ * scale(p) * (divergence_at(here, p) + sums_.inflow.column(0)[p]);
      diagonal_[p] = diagonal_at(p);
      sums_.p.column(0)[p] = s_.p_last.column(0)[p];
    });
  }

  // grad p / rho of the present pressures, in `pressed`.
  void find_gradients() {
    each_row(n_, [&](std::size_t p) {
      const T V = sums_.V.column(0)[p], here = sums_.p.column(0)[p];
      Vp_[p] = V * here, Vp_pressing_[p] = V * std::max(here, T(0));
    });
    each_row(n_, [&](std::size_t p) {
      T across[3];
      pairs_.sum_across(p, across, [&](std::uint32_t e, int count, R(&out)[3]) {
        const std::int32_t* rows = pairs_.row.data() + e;
        const R pressure = gather<R>(Vp_pressing_.data(), rows) * gather<R>(sums_.share.column(0), rows);
        const Vec3<R> g = pairs_.template slope<R>(e, count);
        for (int k = 0; k < 3; ++k) out[k] += pressure * g[k];
      });
      const Vec3<T> other = Vec3<T>{across[0], across[1], across[2]} * sums_.share.column(0)[p] +
                            vector_at(sums_.beside, p) * std::max(sums_.p.column(0)[p], T(0));
      const Vec3<T> gradient = pressure_gradient(pairs_, sums_, Vp_.data(), p, mirrored_at(s_, p)) + other;
      set_vector(sums_.pressed, p, gradient * (T(1) / sums_.rho.column(0)[p]));
    });
    fill_quads(n_, sums_, [&](std::size_t p, int count) { return load_vector<R>(sums_.pressed, p, count); });
    bodies_.find_inflow();
  }

  // The next pressure of a particle, in `p_next`; what is left of the present one, relative.
  T relax(std::size_t p) {
    const T here = sums_.p.column(0)[p], rho0 = sums_.rho0.column(0)[p];
    const T laplacian = sums_.rho.column(0)[p] * divergence_at(vector_at(sums_.pressed, p), p);
    const T left = missing_[p] + dt_ * scale(p) * bodies_.inflow(p) + rho0 / sums_.lam.column(0)[p] * here -
                   dt_ * dt_ * laplacian;
    const T next = here + T(relaxation) / diagonal_[p] * left;
    const bool bound = s_.is_water(p) && !(here > T(0)) && !(left < T(0));  // p = 0 is its answer
    sums_.p_next.column(0)[p] = s_.is_water(p) ? std::max(next, T(0)) : next;
    return bound ? T(0) : std::abs(left) / rho0;
  }

  // `pressed` becomes all of the acceleration that is not given: -grad p / rho and that of viscosity.
  void finish(const Vectors<T>& dragged) {
    set_packs(sums_.pressed, [&](std::size_t p, int count) {
      return load_vector<R>(dragged, p, count) - load_vector<R>(sums_.pressed, p, count);
    });
    each_row(n_, [&](std::size_t p) { sums_.inflow.column(0)[p] += bodies_.inflow(p); });
  }

 private:
  // What the kernel holds, as if water went on beyond its surface [kg/m3].
  T now(std::size_t p) const {
    if (!s_.is_water(p)) return sums_.rho.column(0)[p];
    const T fill = sums_.fill.column(0)[p], most = rest(p) / sums_.rho0.column(0)[p];
    return sums_.rho0.column(0)[p] * (fill < most ? std::min(most, fill + outside(p)) : fill);
  }
  // What is missing of the fill because water ends here: without it, a surface would sink until its kernels are full.
  T outside(std::size_t p) const {
    const Vec3<T> slope = vector_at(sums_.around, p) + vector_at(sums_.beside, p) + vector_at(sums_.walls, p);
    const T excess = spacing_ * std::sqrt(dot(slope, slope)) - T(disorder);
    return T(surface_gap / (surface_slope - disorder)) * std::max(excess, T(0));
  }
  // What `now` may be without pressure.
  T rest(std::size_t p) const { return s_.is_water(p) ? s_.rho_birth.column(0)[p] : sums_.rho0.column(0)[p]; }
  // What div v is multiplied with.
  T scale(std::size_t p) const { return s_.is_water(p) ? sums_.rho0.column(0)[p] : sums_.rho.column(0)[p]; }

  // div u of vectors that are in `quads`, times V, over both phases; at rest at boundaries.
  T divergence_at(const Vec3<T>& here, std::size_t p) const {
    return divergence(pairs_, sums_, here, p) + inflow_across(pairs_, sums_, here, p);
  }

  T diagonal_at(std::size_t p) const {
    T squares[1], across[1];
    const auto weight = [&](std::uint32_t e, int count) {
      const std::int32_t* rows = pairs_.row.data() + e;
      const Vec3<R> g = pairs_.template slope<R>(e, count);
      return R(gather<R>(sums_.V.column(0), rows) / gather<R>(sums_.rho.column(0), rows) * dot(g, g));
    };
    pairs_.sum(p, squares, [&](std::uint32_t e, int count, R(&out)[1]) { out[0] += weight(e, count); });
    pairs_.sum_across(p, across, [&](std::uint32_t e, int count, R(&out)[1]) {
      const R share = gather<R>(sums_.share.column(0), pairs_.row.data() + e) * sums_.share.column(0)[p];
      out[0] += share * share * weight(e, count);
    });
    const Vec3<T> all = vector_at(sums_.around, p) + vector_at(sums_.beside, p),
                  walls = vector_at(sums_.walls, p);
    const T pairs = sums_.rho.column(0)[p] * sums_.V.column(0)[p] * (squares[0] + across[0]);
    return -sums_.rho0.column(0)[p] / sums_.lam.column(0)[p] -
           dt_ * dt_ * (pairs + dot(all + walls * mirrored_at(s_, p), all + walls)) -
           dt_ * scale(p) * bodies_.stiffness(p);
  }

  const SphState<T>& s_;
  const SphPairs<T>& pairs_;
  Floating<T>& bodies_;
  const T dt_, spacing_;
  const T restored_;  // how much of an overfill a step takes back
  SphSums<T>& sums_;
  const std::size_t n_;
  std::vector<T> missing_, diagonal_, Vp_, Vp_pressing_;
};

}  // namespace detail

// Solve the system above by projected relaxed Jacobi steps from the pressures of the last step; `pressed` becomes the
// acceleration by pressure and viscosity, `inflow` that with what the bodies have given way. The residual is that of
// `solve_pressure`, of water without pressure only where it would be too dense.
template <class T>
SolveReport solve_mixture(const CubicKernel<T>& kernel, const Model<T>& world, const SphState<T>& s,
                          const SphBoundary<T>& walls, const SphPairs<T>& pairs, const SphPairs<T>& boundary,
                          double dt, const SolveLimits& limits, SphSums<T>& sums) {
  Vectors<T> dragged;
  dragged.resize(s.count);
  const SolveReport viscous = detail::Viscosity<T>(kernel, s, pairs, dt, sums).solve(limits, dragged);
  if (!viscous.converged) return viscous;
  detail::Floating<T> bodies(world, s, walls, boundary, dt, sums);
  detail::MixtureSolve<T> solve(kernel, s, pairs, bodies, dt, sums);
  solve.start(dragged);
  const SolveReport report = detail::relax_pressures(
      s.count, limits, sums, [&] { solve.find_gradients(); }, [&](std::size_t p) { return solve.relax(p); });
  solve.finish(dragged);
  return report;
}

}  // namespace neve
