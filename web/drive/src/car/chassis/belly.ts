/** The underside of the car where it lies on snow or ploughs through it. */
import { densityRatio, type Column } from "../../snow/law";
import type { SnowType } from "../../snow/types";

/** Share of the underside that bears: it is no plate, snow gives way between axles and pipes. */
const BEARS = 0.05;
/** Resistance of snow that is pushed aside, without speed [Pa]. */
const PUSH = 5e3;
/** Share of the ploughed snow that is brought to the speed of the car. */
const CARRIED = 0.5;
/** Friction of the underside on the snow below it. */
const RUBS = 0.08;
/** Within this distance of the snow its pressure builds up [m]. */
const TOUCH = 0.02;

/**
 * Pressure that a column bears once it is pressed to a depth [Pa]: the law of bearing solved for the pressure,
 * p = -p_k ln(1 - (1 - 1/r) / s). It asks only for the density, so pressed snow goes on bearing.
 */
export function pressureAt(column: Column, depth: number, type: SnowType, compaction: number): number {
  if (column.h < 1e-3) return 0;
  const h = Math.max(0.02 * column.h, Math.min(depth, column.h));
  const ratio = densityRatio(column) * Math.pow(column.h / h, compaction);
  const strain = Math.min(0.99, (1 - 1 / ratio) / type.strain);
  return -type.pressure * Math.log(1 - strain);
}

export interface Patch {
  readonly column: Column;
  readonly type: SnowType;
  readonly compaction: number;
  /** Height of the underside above the bare ground [m]. */
  readonly clearance: number;
  /** [m2] */
  readonly area: number;
}

/** Upward force on a patch of the underside [N]. */
export function lift(patch: Patch): number {
  const { column, clearance } = patch;
  const touch = Math.min(1, Math.max(0, (column.h + TOUCH - clearance) / TOUCH));
  if (touch === 0) return 0;
  const depth = Math.max(0, clearance);
  return touch * BEARS * patch.area * pressureAt(column, depth, patch.type, patch.compaction);
}

/** Force against the motion of a leading edge of `width` [m] that is `deep` below the surface at a speed [m/s], [N]. */
export function plough(type: SnowType, width: number, deep: number, speed: number): number {
  return deep <= 0 ? 0 : width * deep * (PUSH + CARRIED * type.density * speed * speed);
}

/** Friction of a patch that carries `force` [N]. */
export function rubbing(force: number): number {
  return RUBS * force;
}
