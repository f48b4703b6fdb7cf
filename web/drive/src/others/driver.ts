/** A driver for the course: steers at the next gate, keeps a pace, slows down for bends. Pure. */
import type { Controls } from "../car/driver/controls";
import { turn } from "../car/geometry";
import type { CarState } from "../car/state";
import { HALF, type Gate } from "../course/course";

/** Controls of a driver at `state` who wants to pass `gate` at a pace [m/s]. */
export function trackDriver(state: CarState, gate: Gate, pace: number): Controls {
  const [x, , z] = state.position;
  const away = Math.hypot(gate.x - x, gate.z - z);
  // From far away it aims before the gate, so that it passes straight.
  const before = Math.min(2 * HALF, 0.35 * away);
  const [tx, tz] = [gate.x - before * Math.cos(gate.heading), gate.z - before * Math.sin(gate.heading)];
  const aim = away > HALF ? Math.atan2(tz - z, tx - x) : gate.heading;
  const nose = turn(state.rotation, [1, 0, 0]);
  const off = wrap(aim - Math.atan2(nose[2], nose[0]));
  const wanted = pace * Math.max(0.45, 1 - 0.7 * Math.abs(off));
  const missing = wanted - state.speed;
  return {
    steer: Math.max(-1, Math.min(1, 1.8 * off)),
    throttle: Math.max(0, Math.min(1, 0.25 + 0.4 * missing)),
    brake: Math.max(0, Math.min(1, -0.3 * missing - 0.4)),
    handbrake: 0,
    reset: false,
  };
}

/** An angle in -pi..pi. */
function wrap(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}
