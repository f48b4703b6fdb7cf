import type { SnowType } from "./types";

/**
 * The law of the game snow, for one column at a time. It is not physics, it is what games do; but it is written so
 * that the result does not depend on how a press or a span of time is cut into steps. The shaders hold the same law.
 */
export interface Column {
  /** Depth of the snow [m]. */
  readonly h: number;
  /** Its mass, as the depth it had at fresh density [m]. W / h is the density ratio r, 1 for fresh snow. */
  readonly W: number;
}

/** A tyre and what it carries. */
export interface Wheel {
  /** [m] */
  readonly radius: number;
  /** [m] */
  readonly width: number;
  /** [N] */
  readonly load: number;
}

/** Density ratio beyond which nothing is pressed any further: from new snow to nearly ice. */
export const DENSEST = 8;

/** The shortest contact of a tyre, which flattens on hard ground [m]. */
export const SHORTEST_CONTACT = 0.14;

/** How much steeper than loose snow packed snow stands, as a factor of the tangent; it is full at PACKED_RATIO. */
export const PACKED_STEEPER = 2;
export const PACKED_RATIO = 1.4;

/** Density ratio of a column; at least 1, whatever the rounding. */
export function densityRatio({ h, W }: Column): number {
  return h > 1e-6 ? Math.max(1, W / h) : 1;
}

/** Density ratio at which snow of a type bears a pressure [Pa]: 1 / (1 - s (1 - exp(-p / p_k))). */
export function bearingRatio(type: SnowType, pressure: number): number {
  return 1 / (1 + type.strain * Math.expm1(-Math.max(0, pressure) / type.pressure));
}

/**
 * The column pressed to a depth: W' = W (h'/h)^(1-c). Of each layer that is pressed, the share c (compaction) stays
 * and makes the column denser and the rest leaves for the rims: dW / W = (1 - c) dh / h, whose solution does not
 * depend on the number of presses.
 */
export function press(column: Column, depth: number, compaction: number): Column {
  if (depth >= column.h || column.h <= 1e-6) return column;
  const h = Math.max(depth, densestDepth(column, compaction));
  return { h, W: column.W * Math.pow(h / column.h, 1 - compaction) };
}

/** Depth to which a column can be pressed at most [m]: where its ratio r (h'/h)^(-c) reaches DENSEST. */
export function densestDepth(column: Column, compaction: number): number {
  return column.h * Math.pow(Math.min(1, densityRatio(column) / DENSEST), 1 / compaction);
}

/** Depth of a column after it came to bear a pressure [m]: h (r / r_k)^(1/c), or h if it bears it already. */
export function bearingDepth(column: Column, type: SnowType, pressure: number, compaction: number): number {
  const ratio = densityRatio(column) / bearingRatio(type, pressure);
  return ratio < 1 ? column.h * Math.pow(ratio, 1 / compaction) : column.h;
}

/** Contact area of a wheel that has sunk by z [m2]: its width times the chord of the surface, 2 sqrt(R^2 - (R - z)^2). */
export function contactArea(wheel: Wheel, sinkage: number): number {
  const z = Math.min(Math.max(sinkage, 0), wheel.radius);
  const chord = 2 * Math.sqrt(z * (2 * wheel.radius - z));
  return wheel.width * Math.min(2 * wheel.radius, Math.max(SHORTEST_CONTACT, chord));
}

/**
 * Sinkage of a wheel into a column [m]: the z at which the snow below, pressed to h - z, bears load / A(z). The
 * deeper the wheel, the larger A, the smaller what the snow would still yield: one root, found by bisection.
 */
export function wheelSinkage(wheel: Wheel, column: Column, type: SnowType, compaction: number): number {
  const yields = (z: number) =>
    column.h - bearingDepth(column, type, wheel.load / contactArea(wheel, z), compaction);
  if (wheel.load <= 0 || yields(0) <= 0) return 0;
  let [low, high] = [0, column.h];
  for (let i = 0; i < 32; i++) {
    const z = 0.5 * (low + high);
    if (yields(z) > z) low = z;
    else high = z;
  }
  return 0.5 * (low + high);
}

/** What a span of time does to the snow: the shaders get these two numbers. */
export interface Passing {
  /** Share of the distance to fresh snow that is made good, 1 - exp(-dt / tau). */
  readonly gain: number;
  /** Depth of fresh snow that falls into tracks [m]. */
  readonly fall: number;
}

/**
 * The passing of dt seconds with a time constant tau [s] (Infinity: no recovery) and snowfall [m/s]. What is missing
 * to the fresh depth, D, follows dD/dt = -D / tau - snowfall down to 0; solved exactly, so any cutting of dt into
 * steps gives the same: D' = max(0, D exp(-dt/tau) - snowfall tau (1 - exp(-dt/tau))).
 */
export function passing(dt: number, tau: number, snowfall: number): Passing {
  if (!Number.isFinite(tau)) return { gain: 0, fall: snowfall * dt };
  const gain = -Math.expm1(-dt / tau);
  return { gain, fall: snowfall * tau * gain };
}

/**
 * The column after that time over a fresh depth H [m]. Snow that falls has fresh density, and none is left where the
 * track is full; rims above H recover (sink) by the same time constant.
 */
export function recover(column: Column, fresh: number, { gain, fall }: Passing): Column {
  const h = column.h + (fresh - column.h) * gain;
  const W = column.W + (fresh - column.W) * gain;
  const fallen = Math.min(fall, Math.max(0, fresh - h));
  return { h: h + fallen, W: W + fallen };
}

/**
 * Tangent of the angle at which snow stands: that of repose for loose snow, up to PACKED_STEEPER times as steep where
 * one of the two columns is packed, so that ruts keep their walls.
 */
export function standingSlope(repose: number, ratio: number): number {
  const packed = Math.min(1, Math.max(0, (ratio - 1) / (PACKED_RATIO - 1)));
  return Math.tan((repose * Math.PI) / 180) * (1 + (PACKED_STEEPER - 1) * packed);
}

/** Share of the rim that lies beside a wheel; a wheel that spins or is locked (slip [m/s]) moves more behind it. */
export function sideShare(rimShare: number, slip: number): number {
  return rimShare / (1 + Math.abs(slip) / 3);
}
