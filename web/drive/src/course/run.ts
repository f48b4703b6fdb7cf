/** A drive that was recorded, and where its car is at any time: ghosts, and the other car. Pure. */
import { BODY, WHEELS } from "../car/body";
import { add, between, betweenTurns, scale, turn, type Quaternion, type Vec } from "../car/geometry";
import type { CarState } from "../car/state";

/** Samples of a second; a row: x, y, z [m], the four numbers of the rotation, steering and angle rolled [rad]. */
export const RATE = 10;
export const ROW = 9;
/** The longest drive that is kept [s]. */
export const LONGEST = 600;

export interface Drive {
  /** How long it took [s]. */
  readonly time: number;
  readonly rows: readonly number[];
}

/** Takes the samples of a drive. */
export class Recorder {
  private rows: number[] = [];

  /** Begin anew. */
  clear(): void {
    this.rows = [];
  }

  /** The car is so at `time` [s] since the beginning: every sample that is due is taken. */
  take(time: number, state: CarState): void {
    if (time > LONGEST) return;
    while (this.rows.length / ROW <= time * RATE) {
      const wheel = state.wheels[0];
      const row = [...state.position, ...state.rotation, wheel?.steer ?? 0, wheel?.spin ?? 0];
      this.rows.push(...row.map((value) => Math.round(1e4 * value) / 1e4));
    }
  }

  /** The drive until `time` [s]; null if it was too long to be kept. */
  done(time: number): Drive | null {
    return time > LONGEST ? null : { time, rows: [...this.rows] };
  }
}

/** Check what was stored or loaded: a drive, or null. */
export function driveOf(value: unknown): Drive | null {
  const { time, rows } = (value ?? {}) as Partial<Drive>;
  const sound =
    typeof time === "number" &&
    time > 0 &&
    time <= LONGEST &&
    Array.isArray(rows) &&
    rows.length >= 2 * ROW &&
    rows.length % ROW === 0 &&
    rows.every((n) => Number.isFinite(n));
  return sound ? { time, rows: rows as number[] } : null;
}

/** The car of a drive at `time` [s], on wheels of a radius and a width [m]. */
export function carAt(drive: Drive, time: number, radius: number, width: number): CarState {
  const count = drive.rows.length / ROW;
  const at = Math.min(count - 1, Math.max(0, time * RATE));
  const k = Math.min(count - 2, Math.floor(at));
  const [a, b] = [row(drive, k), row(drive, k + 1)];
  const t = at - k;
  const rotation = betweenTurns(a.rotation, b.rotation, t);
  const position = between(a.position, b.position, t);
  const velocity = scale(add(b.position, scale(a.position, -1)), RATE);
  const wheels = WHEELS.map(({ x, z, front }) => ({
    centre: add(position, turn(rotation, [x, -BODY.axle, z])),
    steer: front ? a.steer + (b.steer - a.steer) * t : 0,
    spin: a.spin + (b.spin - a.spin) * t,
    radius,
    width,
    load: 0,
    slip: 0,
    sinkage: 0,
    sideForce: 0,
    grounded: true,
  }));
  const speed = Math.hypot(...velocity);
  const rest = { angular: [0, 0, 0] as Vec, gear: "1", revs: 0, enginePower: 0, ploughing: 0 };
  return { position, rotation, velocity, speed, wheels, ...rest };
}

function row({ rows }: Drive, k: number) {
  const at = (i: number) => rows[k * ROW + i]!;
  const position: Vec = [at(0), at(1), at(2)];
  const rotation: Quaternion = [at(3), at(4), at(5), at(6)];
  return { position, rotation, steer: at(7), spin: at(8) };
}
