// Several steps without the host: the device chooses dt, judges each step before a particle moves, and stops where the host
// is needed. A step that might have to be rejected is not begun, so that no state has to be saved: the host tries it.
//
// Each step: pace_step, clear_nodes, p2g, grid_update, report_nodes, judge_step, g2p. Once `halt` is set they do nothing.
#pragma once

#include "cuda/choices.hpp"
#include "cuda/grid/reduce.hpp"
#include "cuda/solids.hpp"

namespace neve::cuda {

inline constexpr int pace_threads = 128;

template <class T>
NEVE_INLINE bool halted(const Step<T>& s) {
  return s.control != nullptr && s.control->halt != int(Halt::none);
}

// The constants of the step under way.
template <class T>
NEVE_INLINE StepConstants<T> constants_of(const Step<T>& s) {
  StepConstants<T> out = s.constants.step;
  if (s.control != nullptr) out.dt = s.control->step_dt, out.blend = s.control->blend;
  return out;
}

// The number behind ordered(), or 0 where none has come.
inline double number_of(BlockKey key) {
  if (key == 0) return 0;
  constexpr BlockKey sign = BlockKey(1) << 63;
  const BlockKey bits = key & sign ? key ^ sign : ~key;
  double out;
  std::memcpy(&out, &bits, sizeof(out));
  return out;
}

// What g2p has found in the particles.
template <class T>
inline void take_report(Control<T>& c, const Results& found) {
  const auto most = [&](Extreme which) { return number_of(found.most[which]); };
  c.rates = {most(wave),
             most(speed),
             most(fastest),
             std::sqrt(most(rate2)),
             most(compression),
             found.most[less_ice_room] != 0 ? -most(less_ice_room) : std::numeric_limits<double>::infinity()};
  c.max_displacement = std::sqrt(most(displacement2));
  c.min_volume_ratio = -most(less_volume);
}

// End a step that was taken.
template <class T>
inline void end_step(Control<T>& c, const Results& found) {
  take_report(c, found);
  c.record[c.taken++] = {c.dt, c.bound, 0};
  const bool over = ends(c.dt, c.remaining);
  c.remaining -= c.dt;
  c.under_way = 0;
  c.drifted = found.drifted != 0;
  if (c.drifted != 0) c.halt = int(Halt::drifted);
  if (over) c.halt = int(Halt::finished);
  c.broken = found.not_finite != 0;
  if (c.broken != 0) c.halt = int(Halt::broken);
}

// Choose the next one.
template <class T>
inline void choose_step(Control<T>& c) {
  const StepChoice choice = largest_step(c.limits, c.rates);
  const bool shortened = c.limits.dt != 0 && choice.bound != StepBound::fixed;
  if (shortened || !(choice.dt > shortest_share * c.remaining)) {
    c.halt = int(Halt::unusual);
    return;
  }
  c.dt = fitted(choice.dt, c.remaining), c.bound = int(choice.bound);
  c.step_dt = T(c.dt);
  c.blend = FlipBlend<T>::of(c.flip_damping < 0 ? c.flip_alpha : std::exp(-c.flip_damping * c.dt));
}

// End the last step and begin the next: one block of threads.
template <class C>
inline void pace_step(const Step<typename C::T>& s) {
  using N = typename C::Number;
  auto& c = *s.control;
  const bool taken = c.under_way != 0;
  N *attempt = exchanged_of<C>(s), *total = static_cast<N*>(s.accepted);
  for (unsigned k = threadIdx.x; k < s.solid_count * exchange_numbers; k += blockDim.x) {
    if (taken) total[k].add(attempt[k]);
    attempt[k].clear();
  }
  __syncthreads();
  if (threadIdx.x != 0) return;
  if (taken) end_step(c, *s.results);
  if (c.halt != int(Halt::none)) return;
  choose_step(c);
  *s.results = {};
}

// A thread per node.
template <class C>
inline void clear_nodes(const Step<typename C::T>& s) {
  using T = typename C::T;
  if (halted(s)) return;
  const std::size_t i = std::size_t(blockIdx.x) * block_nodes + threadIdx.x;
  s.nodes.node[i] = Quad<T>{};
  if constexpr (C::has_change) s.nodes.change[i] = Quad<T>{};
  if constexpr (C::has_play) s.nodes.lift[i] = Quad<T>{};
}

// Halt before a step that must be tried, by what the nodes would do: one thread.
template <class C>
inline void judge_step(const Step<typename C::T>& s) {
  auto& c = *s.control;
  if (threadIdx.x != 0 || halted(s)) return;
  const Results& found = *s.results;
  const auto most = [&](Extreme which) { return number_of(found.most[which]); };
  const GridReport nodes{std::sqrt(most(node_speed)), std::sqrt(most(node_difference)),
                         std::sqrt(3.0) * most(node_change), found.not_finite == 0};
  if (needs_trial(c.limits, nodes, c.rates, c.dt)) {
    c.halt = int(Halt::trial);
  } else {
    c.under_way = 1;
  }
}

}  // namespace neve::cuda
