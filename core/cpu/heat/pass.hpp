// A pass over the heat of the material point method.
#pragma once

#include "cpu/heat/flow.hpp"
#include "cpu/heat/phase.hpp"

namespace neve {

struct GridHeatReport : HeatReport, PhaseReport {};

// Let heat flow for dt [s] of motion, and let the particles follow: their phases, their strength.
template <class T>
GridHeatReport pass_heat(const Model<T>& model, State<T>& state, double dt) {
  const double own = dt * model.heat->speed;
  detail::HeatNodes<T> nodes(model, state);
  GridHeatReport out;
  static_cast<HeatReport&>(out) = detail::GridHeatFlow<T>(model, state, nodes).flow(own);
  if (out.endless) return out;
  detail::PhaseChange<T> phases(model, state);
  static_cast<PhaseReport&>(out) = phases.change();
  if (model.heat->sinters) phases.sinter(detail::strain_rates(state, nodes), own);
  return out;
}

}  // namespace neve
