// Heat that flows between particles of the material point method by way of the nodes, and to them from air and sun.
//
// Each particle and each node of its stencil are joined by a conductance g_ip = w_ip k_p V_p / D, D = dx^2 / 4 the second moment
// of the quadratic spline; nodes hold no heat, so that T_i = sum_p g_ip T_p / sum_p g_ip, and
//
//   de_p/dt = sum_i g_ip (T_i - T_p)
//
// Every node gives as much as it takes: no heat is lost. All conductances are above zero: heat only flows from warm to cold.
// In evenly filled snow the two sums take the mean of T over the spline twice, which is T + D laplace T for what varies over
// some cells: de_p/dt = V_p k laplace T. Where k changes, conductances in a row add up as those of layers do.
#pragma once

#include "cpu/heat/exposure.hpp"

namespace neve::detail {

// The space that a particle fills [m3]: not more than at birth, as what is torn apart is not, and not less than ice.
template <class T>
double space_of(const State<T>& state, std::size_t p) {
  const double V0 = state.V0.column(0)[p], dense = double(state.m.column(0)[p]) / ice_density;
  Mat3<double> F;
  for (int k = 0; k < 9; ++k) F(k % 3, k / 3) = state.F_E.column(k)[p];
  return std::clamp(V0 * determinant(F) * double(state.J_P.column(0)[p]), std::min(dense, V0), V0);
}

template <class T>
class GridHeatFlow {
 public:
  GridHeatFlow(const Model<T>& model, State<T>& state, HeatNodes<T>& nodes)
      : heat_(*model.heat),
        state_(state),
        nodes_(nodes),
        volume_(state.count),
        conductance_(state.count),
        temperature_(state.count),
        taken_(state.count),
        joined_(nodes.size()),
        mean_(nodes.size()) {
    const double moment = model.dx * model.dx / Quadratic::inverse_inertia;
    each([&](std::size_t p) {
      const double liquid = heat::liquid(state.enthalpy.column(0)[p], mass(p));
      volume_[p] = space_of(state, p);
      conductance_[p] = heat_.conductivity_of(mass(p) / volume_[p], liquid) * volume_[p] / moment;
    });
    nodes.template scatter<1>({joined_.data()}, [&](std::size_t p) { return std::array{conductance_[p]}; });
    if (heat_.exchange > 0 || heat_.sun > 0) {
      Exposure<T> exposure(model, heat_, state, nodes, volume_);
      air_ = std::move(exposure.to_air), sun_ = std::move(exposure.to_sun);
    } else {
      air_.resize(state.count), sun_.resize(state.count);
    }
  }

  // Let heat flow for dt [s], of its own time.
  HeatReport flow(double dt) {
    return flow_in_rounds(
        dt, state_.count, [&](std::size_t p) { return conductance_[p] + heat_.exchange * air_[p]; },
        [&](std::size_t p) { return mass(p); }, [&](double round) { exchange(round); },
        state_.enthalpy.column(0), taken_.data());
  }

 private:
  template <class F>
  void each(F&& f) {
    each_chunk(state_.count, [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) f(p);
    });
  }
  double mass(std::size_t p) const { return state_.m.column(0)[p]; }

  // Let heat flow for a round of dt [s].
  void exchange(double dt) {
    double* e = state_.enthalpy.column(0);
    std::fill(mean_.begin(), mean_.end(), 0.0);
    nodes_.template scatter<1>({mean_.data()}, [&](std::size_t p) {
      temperature_[p] = heat::temperature(e[p], mass(p));
      return std::array{conductance_[p] * temperature_[p]};
    });
    each_chunk(mean_.size(), [&](int, std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) mean_[n] = joined_[n] > 0 ? mean_[n] / joined_[n] : 0.0;
    });
    nodes_.template gather<1>({mean_.data()}, [&](std::size_t p, const std::array<double, 1>& around) {
      const double outside =
          dt * (heat_.exchange * air_[p] * (heat_.air - temperature_[p]) + heat_.sun * sun_[p]);
      e[p] += dt * conductance_[p] * (around[0] - temperature_[p]) + outside, taken_[p] += outside;
    });
  }

  const HeatModel& heat_;
  State<T>& state_;
  HeatNodes<T>& nodes_;
  std::vector<double> volume_, conductance_, temperature_, taken_;
  std::vector<double> joined_, mean_;  // of the nodes: sum of conductances [W/K], temperature [deg C]
  std::vector<double> air_, sun_;
};

}  // namespace neve::detail
