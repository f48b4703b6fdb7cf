// The stress of a state that nothing has moved.
#pragma once

#include "cpu/material.hpp"
#include "mpm/particle_report.hpp"
#include "threads.hpp"

namespace neve {

// Recompute tau from F_E and J_P, and report the rates that limit the time step. Every advance() starts with it, so
// that a run depends on nothing but the state: not on what was left over by a step, a user's edit or a checkpoint.
template <class T>
Report refresh(const Model<T>& model, State<T>& state) {
  using R = Lanes<T>;
  constexpr int L = width<R>;
  constexpr std::size_t chunk = 64 * L;  // particles, of which the lanes are compared once
  return merge_each<Report>((state.count + chunk - 1) / chunk, [&](std::size_t i) {
    Extremes<R> extremes;
    const std::size_t end = std::min(state.count, (i + 1) * chunk);
    for (std::size_t p = i * chunk; p < end; p += L) {
      const int count = std::min<int>(L, static_cast<int>(end - p));
      const Mat3<R> F = load_matrix<R>(state.F_E, p, count);
      const R J_P = load<R>(state.J_P.column(0) + p, count);
      const Stress<R> now = stress(model, state, p, count, F, J_P);
      store_symmetric(state.tau, p, now.tau, count);
      const Vec3<R> x = load_vector<R>(state.x, p, count), v = load_vector<R>(state.v, p, count);
      const Mat3<R> C = load_matrix<R>(state.C, p, count);
      const R sum = sum_of(x) + sum_of(v) + sum_of(F) + sum_of(C) + J_P;
      const R m = load<R>(state.m.column(0) + p, count), V0 = load<R>(state.V0.column(0) + p, count);
      extremes.add(first_lanes<R>(count), v, now.modulus, m, V0, C, sum);
      const R room = detail::ice_room(model, state, p, count, R(determinant(F) * J_P));
      extremes.ice_room = min(room, extremes.ice_room);
    }
    return extremes.report();
  });
}

}  // namespace neve
