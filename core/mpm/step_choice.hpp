// The choice of the time step: fixed, or the largest that the snow's own speeds allow; and which steps must be tried first.
// Formulas and reasons are in neve.mpm.time_step and neve.mpm.step_control.
#pragma once

#include "mpm/report.hpp"

namespace neve {

// What bounds a step.
enum class StepBound { wave, speed, solid, strain, fixed, dt_max };
inline constexpr const char* step_bounds[] = {"wave", "speed", "solid", "strain", "fixed", "dt_max"};

// A step that is a smaller share of the time that remains makes no progress.
inline constexpr double shortest_share = 1e-9;

struct StepLimits {
  double dx;               // [m]
  double cfl, courant;     // largest (c + |v|) dt / dx, c dt / dx [1]
  double strain_max;       // dt |grad v| [1]
  double dt_max;           // [s]
  double dt;               // the user's own [s]; 0: the longest good one
  double max_compression;  // -dt tr grad v [1]
  double solid_speed;      // [m/s]

  // Beyond it a step is rejected.
  double largest_strain() const { return 4 * strain_max; }
};

// What a step follows from: as in Report.
struct ParticleRates {
  double wave, speed, fastest, strain_rate, compression_rate, ice_room;
};

struct StepChoice {
  double dt;  // [s]
  StepBound bound;
};

// The longest step in which no vibration of the snow grows [s].
inline double stable_step(const StepLimits& limits, const ParticleRates& rates) {
  return rates.wave > 0 ? limits.courant * limits.dx / rates.wave : std::numeric_limits<double>::infinity();
}

// The automatic step.
inline StepChoice longest_stable(const StepLimits& limits, const ParticleRates& rates) {
  StepChoice best{limits.dt_max, StepBound::dt_max};
  const double way = limits.cfl * limits.dx, compression = 0.5 * limits.max_compression;
  if (rates.fastest * best.dt > way)
    best = {way / rates.fastest, rates.wave >= rates.speed ? StepBound::wave : StepBound::speed};
  if (stable_step(limits, rates) < best.dt) best = {stable_step(limits, rates), StepBound::wave};
  if (limits.solid_speed * best.dt > way) best = {way / limits.solid_speed, StepBound::solid};
  if (rates.strain_rate * best.dt > limits.strain_max)
    best = {limits.strain_max / rates.strain_rate, StepBound::strain};
  if (rates.compression_rate * best.dt > compression)
    best = {compression / rates.compression_rate, StepBound::strain};
  return best;
}

// The step that the scene allows: a user's own is shortened where it would be unstable.
inline StepChoice largest_step(const StepLimits& limits, const ParticleRates& rates) {
  if (limits.dt == 0) return longest_stable(limits, rates);
  const double stable = stable_step(limits, rates);
  return limits.dt <= stable ? StepChoice{limits.dt, StepBound::fixed} : StepChoice{stable, StepBound::wave};
}

// The step that divides `remaining` [s] evenly and does not exceed dt.
inline double fitted(double dt, double remaining) {
  return remaining / max(1.0, std::ceil(remaining / dt * (1 - 1e-9)));
}

// Whether nothing is left of `remaining` after dt, but for rounding.
inline bool ends(double dt, double remaining) { return remaining <= dt * (1 + 1e-9); }

// Whether a step of dt might have to be rejected, so that it must be tried first; by what the nodes will do and by the
// particles' rates in the last step.
inline bool needs_trial(const StepLimits& limits, const GridReport& nodes, const ParticleRates& before,
                        double dt) {
  constexpr double safe_strain =
      0.5;  // of dt |grad v|: (1 - 0.5)^3 = 0.125 of the volume is left, above the limit
  constexpr double safe_displacement = 0.9, share = 0.9, root3 = 1.7320508075688772;
  const double per_cell = dt / limits.dx;
  const double strain = max(root3 * nodes.max_velocity_difference * per_cell, before.strain_rate * dt);
  const double displacement = max(nodes.speed, before.speed + nodes.max_velocity_change) * per_cell;
  const double ice_room = before.ice_room * (1 - root3 * strain);  // |tr grad v| <= sqrt(3) |grad v|
  const bool harmless = strain <= min(safe_strain, share * limits.largest_strain()) &&
                        before.compression_rate * dt <= share * limits.max_compression &&
                        displacement <= safe_displacement && ice_room > 1;
  return !(nodes.finite && harmless);
}

}  // namespace neve
