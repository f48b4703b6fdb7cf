/** What a wheel meets: how high the snow bears it, how it is slowed, and how the walls of its rut hold it. */
import type { Column } from "../../snow/law";
import { bearingDepth, contactArea, densityRatio, wheelSinkage } from "../../snow/law";
import { mixSnow, type SnowType } from "../../snow/types";
import type { Terrain } from "../../world/terrain_type";

/** The snow at a place. */
export type SnowSample = (x: number, z: number) => Column;

export interface Surroundings {
  readonly terrain: Terrain;
  readonly snow: SnowSample;
  /** Share of what is pressed that is compacted. */
  readonly compaction: number;
  /** Powder other than the usual one. */
  readonly powder?: SnowType;
}

export interface RollingWheel {
  readonly x: number;
  readonly z: number;
  /** Unit vector of its heading on the map. */
  readonly ahead: readonly [number, number];
  /** Which way it moves: 1 ahead, -1 back. */
  readonly sense: number;
  readonly speed: number; // m/s, not negative
  readonly slip: number; // m/s
  readonly load: number; // N
  readonly radius: number; // m
  readonly width: number; // m
}

export interface Meeting {
  /** Height of what bears the wheel [m], and the upward normal there. */
  height: number;
  normal: [number, number, number];
  /** How deep the wheel sinks into the snow that it comes to [m]. */
  sinkage: number;
  /** Force against rolling [N]. */
  resistance: number;
  /** Sideways hold of the walls of the rut [N]. */
  holdLeft: number;
  holdRight: number;
  type: SnowType;
}

/** Share of the pressure under a wheel that acts on average while it presses the snow down. */
const MEAN_PRESSURE = 0.25;
/** Share of the snow before the wheel that is brought to its speed. */
const CARRIED = 0.25;
/** A wall holds with this share of the pressure that packs its snow; loose snow needs some packing first. */
const WALL_SHARE = 0.3;
/** How a spinning wheel digs: part of the load that is added per m/s of slip, and at most. */
const DIG = 0.1;
const DIG_MOST = 0.8;

/**
 * What the wheel meets.
 *
 * Sinkage and pressure follow from the column ahead of the print of the wheel, so that a wheel that stands in its own
 * print does not sink again; the height then is what bears this pressure below the wheel, pressed already or not.
 * The resistance is the work of compaction per metre, (share of) pressure x width x sinkage, and the momentum that
 * the snow before the wheel takes, density x width x sinkage x speed^2, both times the type's factor for play.
 */
export function meet(where: Surroundings, wheel: RollingWheel): Meeting {
  const { terrain, snow, compaction } = where;
  const { x, z, radius, width, ahead, sense, speed } = wheel;
  const [ax, az] = ahead;
  const type = mixSnow(terrain.kinds(x, z), where.powder);
  const load = Math.max(wheel.load, 200) * (1 + Math.min(DIG_MOST, DIG * Math.abs(wheel.slip)));
  const loaded = { radius, width, load };
  const front = sense * (radius + 0.1);
  const sinkage = wheelSinkage(loaded, snow(x + front * ax, z + front * az), type, compaction);
  const pressure = load / contactArea(loaded, sinkage);
  const bears = (dx: number, dz: number) =>
    terrain.height(x + dx, z + dz) + bearingDepth(snow(x + dx, z + dz), type, pressure, compaction);

  const reach = 0.6 * radius;
  const side = 0.5 * width;
  const [fore, aft] = [bears(reach * ax, reach * az), bears(-reach * ax, -reach * az)];
  const [left, right] = [bears(side * az, -side * ax), bears(-side * az, side * ax)];
  // Over a crest the wheel rides softly; into a dip, its own print above all, it goes until its rim rests on the edges.
  const middle = bears(0, 0);
  const dip = 0.5 * (fore + aft) - middle;
  const curve = radius - Math.sqrt(radius * radius - reach * reach);
  const height = middle + (dip > 0 ? Math.max(0, dip - curve) : 0.5 * dip);
  const along = steep((fore - aft) / (2 * reach));
  const across = steep((right - left) / (2 * side));
  const [gx, gz] = [along * ax - across * az, along * az + across * ax];
  const length = Math.hypot(gx, 1, gz);

  const chord = contactArea(loaded, sinkage) / width;
  const out = side + 0.1;
  const hold = (dx: number, dz: number) => {
    const column = snow(x + dx, z + dz);
    const wall = Math.min(Math.max(0, terrain.height(x + dx, z + dz) + column.h - height), column.h);
    const firm = WALL_SHARE * Math.min(type.pressure, 60e3) * Math.min(3, densityRatio(column));
    return Math.min(wheel.load, wall * chord * firm);
  };
  const packing = MEAN_PRESSURE * pressure + CARRIED * type.density * speed * speed;
  return {
    height,
    normal: [-gx / length, 1 / length, -gz / length],
    sinkage,
    resistance: Math.min(1.5 * wheel.load, type.drag * width * sinkage * packing),
    holdLeft: hold(out * az, -out * ax),
    holdRight: hold(-out * az, out * ax),
    type,
  };
}

/** A slope that a pad can have: a wheel feels no wall as a floor. */
function steep(slope: number): number {
  return Math.min(1, Math.max(-1, slope));
}
