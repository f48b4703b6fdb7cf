// The particles of a home, a batch at a time, with their stencils.
#pragma once

#include "cpu/grid/stencil.hpp"
#include "cpu/way.hpp"
#include "mpm/model.hpp"
#include "transfer/weights.hpp"

namespace neve {

namespace detail {

// Call f(first particle, how many, stencils) for each batch of a home.
template <class T, class Spline, class F>
void each_batch(const Model<T>& model, const State<T>& state, const Home& home, F&& f) {
  using R = Lanes<T>;
  Stencils<T, Spline> st;
  const auto frame = TileFrame<T>::template of<Spline>(model.dx, home.at);
  for (std::uint32_t done = 0; done < home.count; done += width<R>) {
    const std::size_t p = home.begin + done;
    const int count = std::min<int>(width<R>, static_cast<int>(home.count - done));
    st.template fill<GradientWeights>(frame, load_way<R>(state, frame, p, count));
    f(p, count, st);
  }
}

}  // namespace detail

}  // namespace neve
