/** A marked course: gates in a ring about the start, passed in order against the clock. Pure. */
import type { CarState } from "../car/state";
import { woodland } from "../world/places";
import type { Terrain } from "../world/terrain_type";
import { Recorder, type Drive } from "./run";

/** Gates, half the width of one [m], and the distances from the middle among which the land chooses [m]. */
export const GATES = 10;
export const HALF = 4.5;
const RADII = [44, 52, 60, 68, 76, 84] as const;

/** Two poles, HALF to the left and right of (x, z), and the direction in which they are passed: (cos, sin) in (x, z). */
export interface Gate {
  readonly x: number;
  readonly z: number;
  readonly heading: number;
}

/** Choose the places of the gates: level, open, and in a ring without sharp corners. */
export function layCourse(terrain: Terrain, seed: number): Gate[] {
  const unease = (x: number, z: number) => {
    const [a, b] = terrain.slope(x, z);
    return 6 * Math.hypot(a, b) + 3 * woodland(x, z, seed) + 2 * terrain.kinds(x, z)[2];
  };
  const places: { x: number; z: number; r: number }[] = [];
  for (let k = 0; k < GATES; k++) {
    const angle = (2 * Math.PI * k) / GATES;
    const before = places[k - 1]?.r ?? 60;
    const choices = RADII.map((r) => {
      const [x, z] = [r * Math.cos(angle), r * Math.sin(angle)];
      return { x, z, r, cost: unease(x, z) + Math.abs(r - before) / 16 };
    });
    places.push(choices.reduce((least, one) => (one.cost < least.cost ? one : least)));
  }
  return places.map(({ x, z }, k) => {
    const [last, next] = [places[(k + GATES - 1) % GATES]!, places[(k + 1) % GATES]!];
    return { x, z, heading: Math.atan2(next.z - last.z, next.x - last.x) };
  });
}

/**
 * When a way from one place to another passes a gate forward: the share of the way, 0..1; null if it does not pass
 * between the poles.
 */
export function crossing(
  gate: Gate,
  from: readonly [number, number],
  to: readonly [number, number],
): number | null {
  const [c, s] = [Math.cos(gate.heading), Math.sin(gate.heading)];
  const ahead = ([x, z]: readonly [number, number]) => c * (x - gate.x) + s * (z - gate.z);
  const aside = ([x, z]: readonly [number, number]) => c * (z - gate.z) - s * (x - gate.x);
  const [a, b] = [ahead(from), ahead(to)];
  if (!(a < 0 && b >= 0)) return null;
  const t = a / (a - b);
  return Math.abs(aside(from) + (aside(to) - aside(from)) * t) <= HALF ? t : null;
}

export type Event = "started" | "passed" | "finished" | "record";

export class Course {
  readonly gates: readonly Gate[];
  /** The gate that counts next; a run begins and ends at gate 0. */
  next = 0;
  /** Time of the run so far [s]; null before the start. */
  time: number | null = null;
  /** The fastest run, and what this one is behind it at the gate that was passed last [s]. */
  best: Drive | null = null;
  behind: number | null = null;
  private readonly recorder = new Recorder();
  private splits: number[] = [];
  private bestSplits: number[] = [];
  private from: readonly [number, number] | null = null;

  constructor(gates: readonly Gate[]) {
    this.gates = gates;
  }

  /** Give up the run. */
  abandon(): void {
    this.time = this.behind = this.from = null;
    this.next = 0;
  }

  /** The car is here after dt [s]; what happened. */
  step(dt: number, state: CarState): Event | null {
    const to = [state.position[0], state.position[2]] as const;
    const from = this.from;
    this.from = to;
    if (this.time !== null) {
      this.time += dt;
      this.recorder.take(this.time, state);
    }
    // Nobody drives 10 m in a frame: the car was put elsewhere.
    if (!from || Math.hypot(to[0] - from[0], to[1] - from[1]) > 10) return null;
    const t = crossing(this.gates[this.next]!, from, to);
    return t === null ? null : this.passed((1 - t) * dt, state);
  }

  /** The gate was passed `ago` [s] before now. */
  private passed(ago: number, state: CarState): Event {
    const time = this.time === null ? null : this.time - ago;
    const finished = time !== null && this.next === 0;
    if (time !== null) {
      this.splits.push(time);
      const before = this.bestSplits[this.splits.length - 1];
      this.behind = before === undefined ? null : time - before;
    }
    const record = finished && (this.best === null || time < this.best.time);
    if (record) this.keep(time);
    if (time === null || finished) this.begin(ago, state);
    this.next = (this.next + 1) % this.gates.length;
    return time === null ? "started" : record ? "record" : finished ? "finished" : "passed";
  }

  private keep(time: number): void {
    this.best = this.recorder.done(time);
    this.bestSplits = [...this.splits];
  }

  private begin(ago: number, state: CarState): void {
    this.time = ago;
    this.splits = [];
    this.recorder.clear();
    this.recorder.take(ago, state);
  }
}

/** A time as minutes, seconds and tenths. */
export function clock(time: number): string {
  const tenths = Math.floor(10 * time + 1e-6);
  const [minutes, rest] = [Math.floor(tenths / 600), tenths % 600];
  return `${minutes}:${String(Math.floor(rest / 10)).padStart(2, "0")}.${rest % 10}`;
}

/** What the page says of a run. */
export function tellCourse({ gates, next, time, best, behind }: Course): string {
  const record = best ? `best ${clock(best.time)}` : "";
  if (time === null) return record;
  const passed = (next + gates.length - 1) % gates.length;
  const sign = behind === null ? "" : `  ${behind < 0 ? "−" : "+"}${Math.abs(behind).toFixed(1)}`;
  return `${clock(time)}${sign}   gate ${passed} of ${gates.length}   ${record}`.trimEnd();
}
