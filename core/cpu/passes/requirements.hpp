// What the stages ask of a model, a state and a grid, before they touch memory. Errors: std::invalid_argument,
// which Python sees as ValueError.
#pragma once

#include <stdexcept>

#include "cpu/grid/grid.hpp"
#include "mpm/dispatch.hpp"

namespace neve {

template <class T>
void require_modes(const Model<T>& model, const State<T>& state) {
  if ((state.rest.components() > 0) != model.sleeps())
    throw std::invalid_argument(
        "particles may sleep in the model and not in the state, or the other way round");
  if (state.has_heat() != model.heat.has_value())
    throw std::invalid_argument("the model has heat and the state has none, or the other way round");
  if (state.modes.components() != 3 * velocities(model))
    throw std::invalid_argument("the state has another number of velocity modes than the model");
}
template <class T>
void require_sorted(const Model<T>& model, const State<T>& state, const Grid<T>& grid) {
  if (!grid.current || grid.count != state.count || grid.has_change != keeps_change(model)) {
    throw std::invalid_argument("the grid does not hold this state: call sort() first");
  }
  require_modes(model, state);
}
template <class T>
void require_snow(const Model<T>& model, const State<T>& state) {
  for (std::size_t p = 0; p < state.count; ++p) {
    if (state.material[p] >= model.snows.size())
      throw std::invalid_argument("a particle names a material that the model lacks");
  }
}

}  // namespace neve
