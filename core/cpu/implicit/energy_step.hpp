// The equations of one implicit step on the nodes, M (v - v_n - dt g) = dt f(v) + impulses of the solids: what is left over at
// a velocity, and its derivative.
//
// A particle deforms to F = f F_E, f = I + dt grad v, and its force is that of the stress that the return map leaves of it:
// f_i = -sum_p V0 tau(F) f^-T g_ip. Of a learned energy it is P F_E^T in place of tau f^-T.
#pragma once

#include "cpu/implicit/diagonal.hpp"
#include "cpu/implicit/midpoint.hpp"
#include "cpu/implicit/tangents.hpp"
#include "transfer/scales.hpp"

namespace neve {

// What a pass over the particles found: the smallest det f, and whether all is finite.
struct StretchReport {
  double least_volume = 1;
  bool finite = true;
  void merge(const StretchReport& o) {
    least_volume = min(o.least_volume, least_volume);
    finite = finite && o.finite;
  }
};

// A transfer as an implicit step needs it: its spline, and what makes velocity gradients.
template <class T, class Spline, class Weights>
class ImplicitStep {
  using R = Lanes<T>;

 public:
  // `learned`: the energies that take the place of laws and their flow, if any do.
  ImplicitStep(const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt,
               LearnedEnergies<T>* learned)
      : model_(model), state_(state), grid_(grid), dt_(dt), learned_(learned) {
    const auto cells = CellScales<T>::template of<Spline>(model.dx);
    scale_ = std::is_same_v<Weights, GradientWeights> ? cells.gradient : cells.affine;
  }

  // to += dt f at the start of the step, from the stress that the particles have.
  void add_force(NodeField<T>& to) const {
    const T factor = T(-dt_) * scale_;
    add_through_particles<T, Spline, Weights>(model_, state_, grid_, static_cast<NodeField<T>*>(nullptr), to,
                                              [&](std::size_t p, int count, const Mat3<R>&) {
                                                const R V0 = load<R>(state_.V0.column(0) + p, count);
                                                return scaled(full(load_symmetric<R>(state_.tau, p, count)),
                                                              V0 * factor);
                                              });
  }

  // to += dt f at the end of the step, of particles that deform by f and flow.
  void add_force(NodeField<T>& v, NodeField<T>& to) const {
    const T factor = T(-dt_) * scale_;
    add_through_particles<T, Spline, Weights>(
        model_, state_, grid_, &v, to, [&](std::size_t p, int count, const Mat3<R>& G) {
          const Mat3<R> f = step_of(G), F_E = load_matrix<R>(state_.F_E, p, count);
          const R J_P = load<R>(state_.J_P.column(0) + p, count),
                  V0 = load<R>(state_.V0.column(0) + p, count);
          const Mat3<R> F = detail::quiet(f * F_E, first_lanes<R>(count));
          if (learned_) return scaled(learned_force(p, count, F, F_E, J_P), V0 * factor);
          const Stress<R> end = flowed_stress(model_, state_, p, count, F, J_P);
          return scaled(full(end.tau) * detail::inverse_transposed(f), V0 * factor);
        });
  }

  // to += H u, the derivative of -dt f by the velocity, as `tangents` has it.
  void add_stiffness(const Tangents<T>& tangents, NodeField<T>& u, NodeField<T>& to) const {
    add_through_particles<T, Spline, Weights>(
        model_, state_, grid_, &u, to,
        [&](std::size_t p, int count, const Mat3<R>& G) { return tangents.times_gradient(p, count, G); });
  }

  // to += the diagonal of H, of the particles of homes with wanted(home).
  template <class Wanted>
  void add_diagonal(const Tangents<T>& tangents, NodeField<T>& to, Wanted&& wanted) const {
    add_stiffness_diagonal<T, Spline, Weights>(model_, state_, grid_, tangents, to, wanted);
  }

  // to += the impulses that one rounding of each particle's F makes along its axes, each of a sign of its own.
  void add_rounding(const Tangents<T>& tangents, NodeField<T>& to) const {
    const T size = std::numeric_limits<T>::epsilon() / (T(2) * T(dt_) * scale_);
    add_through_particles<T, Spline, Weights>(model_, state_, grid_, static_cast<NodeField<T>*>(nullptr), to,
                                              [&](std::size_t p, int count, const Mat3<R>&) {
                                                return tangents.times_gradient(p, count, signs(p, size));
                                              });
  }

  // The tangents at the velocity v, times beta; `elastic`: see Tangents::set.
  void linearise(NodeField<T>& v, double beta, bool project, double elastic, Tangents<T>& out) const {
    out.resize(state_.count);
    const double factor = beta * dt_ * dt_ * double(scale_) * double(scale_);
    each_gradient<StretchReport, T, Spline, Weights>(
        model_, state_, grid_, v, [&](std::size_t p, int count, const Mat3<R>& G) {
          const Mat3<R> F_E = load_matrix<R>(state_.F_E, p, count);
          out.set(model_, state_, p, count, step_of(G) * F_E, F_E, load<R>(state_.J_P.column(0) + p, count),
                  factor, project, elastic, learned_);
          return StretchReport{};
        });
  }

  // Expand learned energies around what the velocity v makes of the particles: their forces are then those of the law.
  void expand(NodeField<T>& v) const {
    learned_->resize(state_.count);
    each_gradient<StretchReport, T, Spline, Weights>(
        model_, state_, grid_, v, [&](std::size_t p, int count, const Mat3<R>& G) {
          const Mat3<R> F = step_of(G) * load_matrix<R>(state_.F_E, p, count);
          learned_->expand(model_, state_, p, count, detail::quiet(F, first_lanes<R>(count)),
                           load<R>(state_.J_P.column(0) + p, count));
          return StretchReport{};
        });
  }

  // What the change d of the nodes will give to the particles, once they have moved.
  void gather_late(NodeField<T>& d, LateChange<T>& out) const {
    out.template gather<Spline, Weights>(model_, state_, grid_, d, scale_);
  }

  // How far the step would deform the particles.
  StretchReport look(NodeField<T>& v) const {
    return each_gradient<StretchReport, T, Spline, Weights>(
        model_, state_, grid_, v,
        [&](std::size_t, int count, const Mat3<R>& G) { return report(count, step_of(G)); });
  }

 private:
  // f = I + dt grad v.
  Mat3<R> step_of(const Mat3<R>& G) const { return identity<R>() + scaled(G, T(dt_) * scale_); }

  // A diagonal of +-size for each particle of a pack, by bits of a multiple of its number (Knuth's hash).
  static Mat3<R> signs(std::size_t p, T size) {
    alignas(64) T of[3][width<R>];
    for (std::size_t lane = 0; lane < std::size_t(width<R>); ++lane) {
      const std::uint64_t bits = std::uint64_t(p + lane) * 0x9E3779B97F4A7C15u;
      for (int k = 0; k < 3; ++k) of[k][lane] = bits >> (63 - k) & 1 ? size : -size;
    }
    const R zero = splat<R>(0);
    const auto row = [&](int k) { return load<R>(of[k], width<R>); };
    return {{row(0), zero, zero}, {zero, row(1), zero}, {zero, zero, row(2)}};
  }

  // P F_E^T of a learned energy, and of ice.
  Mat3<R> learned_force(std::size_t p, int count, const Mat3<R>& F, const Mat3<R>& F_E, const R& J_P) const {
    Mat3<R> P = learned_->respond(model_, state_, p, count, F, svd3(F), false).P;
    const R J = determinant(F) * J_P;
    if (any(near_ice(detail::ice_room(model_, state_, p, count, J)))) {
      Stress<R> ice{};
      detail::add_ice(model_, state_, p, count, J, T(0), ice);
      const Mat3<R> more = full(ice.tau) * detail::inverse_transposed(F);
      for (int j = 0; j < 3; ++j) P.column(j) = P.column(j) + more.column(j);
    }
    return detail::times_transposed(P, F_E);
  }

  static StretchReport report(int count, const Mat3<R>& f) {
    const auto here = first_lanes<R>(count);
    const R volume = select(here, determinant(f), splat<R>(1));
    StretchReport out;
    out.finite = !any(volume - volume != R{});
    out.least_volume = -double(max_lane(-volume));
    return out;
  }

  const Model<T>& model_;
  const State<T>& state_;
  Grid<T>& grid_;
  double dt_;
  LearnedEnergies<T>* learned_;
  T scale_;
};

// f(the equations of a step of dt [s]), with the spline and the weights of the model.
template <class T, class F>
void with_implicit_step(const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt,
                        LearnedEnergies<T>* learned, F&& f) {
  with_spline(model.spline, [&](auto spline) {
    using Spline = decltype(spline);
    const bool gradient = with_transfer(model, [](auto transfer) {
      return std::is_same_v<typename decltype(transfer)::GatherWeights, GradientWeights>;
    });
    if (gradient) {
      f(ImplicitStep<T, Spline, GradientWeights>(model, state, grid, dt, learned));
    } else {
      f(ImplicitStep<T, Spline, AffineWeights>(model, state, grid, dt, learned));
    }
  });
}

}  // namespace neve
