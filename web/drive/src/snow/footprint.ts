import { Vector4 } from "three";
import { sideShare } from "./law";
import { common, type Rect } from "./window/rects";
import type { Place, Stamp } from "./stamps";

/** Most stamps that one set of passes takes; more are done in further sets. */
export const STAMPS = 8;

/** How far rims reach beside and behind a footprint [m]; the lobes of the shader have died away there. */
export const RIM_REACH = 0.45;

/** A wheel that moved further than this since the last update was put there, it did not roll [m]. */
const LONGEST_ROLL = 4;

/** Half of a stamp's length and width [m]. */
function halves(stamp: Stamp): [number, number] {
  return stamp.shape === "wheel" ? [stamp.radius, stamp.width / 2] : [stamp.length / 2, stamp.width / 2];
}

/** Where a stamp came from, or where it is if it did not roll here. */
export function origin(stamp: Stamp): Place {
  const { from } = stamp;
  if (!from || Math.hypot(from.x - stamp.x, from.z - stamp.z) > LONGEST_ROLL) return stamp;
  return from;
}

/** The texels of the world that a stamp can change, its rims included. */
export function stampRect(stamp: Stamp, texel: number): Rect {
  const [along, across] = halves(stamp);
  const [c, s] = [Math.abs(Math.cos(stamp.heading)), Math.abs(Math.sin(stamp.heading))];
  const reachX = along * c + across * s + RIM_REACH;
  const reachZ = along * s + across * c + RIM_REACH;
  const from = origin(stamp);
  return {
    x0: Math.floor((Math.min(stamp.x, from.x) - reachX) / texel),
    z0: Math.floor((Math.min(stamp.z, from.z) - reachZ) / texel),
    x1: Math.ceil((Math.max(stamp.x, from.x) + reachX) / texel),
    z1: Math.ceil((Math.max(stamp.z, from.z) + reachZ) / texel),
  };
}

/**
 * A rectangle in which snow may slide after a stamp: what it changes, a margin, and, since walls need several updates
 * to settle, what it has just left.
 */
export function slideRect(stamp: Stamp, texel: number, dt: number): Rect {
  const { x0, z0, x1, z1 } = stampRect(stamp, texel);
  const from = origin(stamp);
  // What was left in the last quarter of a second, at most three metres.
  const trail =
    dt > 0 ? Math.min(0.25 / dt, 3 / Math.max(1e-6, Math.hypot(stamp.x - from.x, stamp.z - from.z))) : 0;
  const [dx, dz] = [(from.x - stamp.x) * trail, (from.z - stamp.z) * trail].map((d) => Math.round(d / texel));
  const margin = Math.round(0.2 / texel);
  return {
    x0: x0 + Math.min(0, dx!) - margin,
    z0: z0 + Math.min(0, dz!) - margin,
    x1: x1 + Math.max(0, dx!) + margin,
    z1: z1 + Math.max(0, dz!) + margin,
  };
}

/** Stamps as the shaders read them: four vectors each, in metres from the least corner of the window. */
export class StampUniforms {
  readonly vectors = Array.from({ length: 4 * STAMPS }, () => new Vector4());
  readonly bounds = Array.from({ length: STAMPS }, () => new Vector4());
  count = 0;

  set(stamps: readonly Stamp[], window: Rect, texel: number, rimShare: number): void {
    this.count = stamps.length;
    stamps.forEach((stamp, i) => {
      const [place, shape, motion, more] = this.vectors.slice(4 * i, 4 * i + 4) as [
        Vector4,
        Vector4,
        Vector4,
        Vector4,
      ];
      const from = origin(stamp);
      const [along, across] = halves(stamp);
      const [c, s] = [Math.cos(stamp.heading), Math.sin(stamp.heading)];
      const isWheel = stamp.shape === "wheel";
      // Behind is where it came from: a car that backs up leaves its rims in front.
      const travel = (stamp.x - from.x) * c + (stamp.z - from.z) * s < 0 ? -1 : 1;
      place.set(stamp.x - window.x0 * texel, stamp.y, stamp.z - window.z0 * texel, isWheel ? 1 : 0);
      shape.set(c, s, along, across);
      motion.set(from.x - stamp.x, from.y - stamp.y, from.z - stamp.z, travel);
      if (isWheel) more.set(Math.min(0.04, stamp.width / 4), 0, sideShare(rimShare, stamp.slip), 0);
      else more.set(stamp.slopeAlong, stamp.slopeAcross, rimShare, 0);
      const { x0, z0, x1, z1 } = common(stampRect(stamp, texel), window);
      this.bounds[i]!.set(x0 - window.x0, z0 - window.z0, x1 - window.x0, z1 - window.z0);
    });
  }
}
