import { origin } from "./footprint";
import { press, type Column } from "./law";
import type { Stamp } from "./stamps";

/** Stamps that are remembered at most: seconds of a car, even where the GPU is far behind. */
const MOST = 1024;
/** The shader rounds the shoulders of a tyre by this much at most [m]; see StampUniforms. */
const SHOULDER = 0.04;

/** The part of 0..1 in which |q - s dq| <= r; empty where the first is greater than the second. */
function within(q: number, dq: number, r: number): [number, number] {
  if (Math.abs(dq) < 1e-6) return Math.abs(q) <= r ? [0, 1] : [1, 0];
  const [a, b] = [(q - r) / dq, (q + r) / dq];
  return [Math.max(0, Math.min(a, b)), Math.min(1, Math.max(a, b))];
}

/**
 * Height of the underside of a stamp over a place [m], the least while it came from where it was; Infinity beside it.
 * shaders.ts holds the same.
 */
export function underside(stamp: Stamp, x: number, z: number): number {
  const [c, s] = [Math.cos(stamp.heading), Math.sin(stamp.heading)];
  const turned = (dx: number, dz: number) => [c * dx + s * dz, c * dz - s * dx] as const;
  const from = origin(stamp);
  const [px, pz] = turned(x - stamp.x, z - stamp.z);
  const [dx, dz] = turned(from.x - stamp.x, from.z - stamp.z);
  const [along, across] = [stamp.shape === "wheel" ? stamp.radius : stamp.length / 2, stamp.width / 2];
  const [u, v] = [within(px, dx, along), within(pz, dz, across)];
  const [first, last] = [Math.max(u[0], v[0]), Math.min(u[1], v[1])];
  if (first > last) return Infinity;
  const rise = from.y - stamp.y;
  if (stamp.shape === "box") {
    const at = (t: number) => t * rise + stamp.slopeAlong * (px - t * dx) + stamp.slopeAcross * (pz - t * dz);
    return stamp.y + Math.min(at(first), at(last));
  }
  const t = Math.abs(dx) < 1e-6 ? first : Math.min(last, Math.max(first, px / dx));
  const curve = Math.min(SHOULDER, stamp.width / 4);
  const over = Math.min(curve, Math.max(0, Math.abs(pz - t * dz) - (across - curve)));
  const shoulder = curve - Math.sqrt(curve * curve - over * over);
  const q = px - t * dx;
  return stamp.y + t * rise + shoulder - Math.sqrt(Math.max(0, stamp.radius ** 2 - q * q));
}

/**
 * The stamps that a copy of the snow from the GPU does not hold yet. They press a column as the GPU does, so that what
 * wheels meet does not depend on how late the copies come: a rear wheel finds the rut of the front one.
 */
export class Prints {
  private readonly stamps: { readonly stamp: Stamp; readonly turn: number }[] = [];
  private turn = 0;

  /** Remember the stamps of an update; returns a number for this moment. */
  add(stamps: readonly Stamp[]): number {
    this.turn++;
    for (const stamp of stamps) this.stamps.push({ stamp, turn: this.turn });
    this.stamps.splice(0, Math.max(0, this.stamps.length - MOST));
    return this.turn;
  }

  /** Forget the stamps up to a moment: a copy of the snow holds them. */
  forget(turn: number): void {
    const kept = this.stamps.findIndex((print) => print.turn > turn);
    this.stamps.splice(0, kept < 0 ? this.stamps.length : kept);
  }

  /** A column at (x, z) over ground of a height [m], pressed by what is remembered. */
  press(column: Column, x: number, z: number, ground: number, compaction: number): Column {
    let least = Infinity;
    for (const { stamp } of this.stamps) least = Math.min(least, underside(stamp, x, z));
    return least < Infinity ? press(column, Math.max(0, least - ground), compaction) : column;
  }
}
