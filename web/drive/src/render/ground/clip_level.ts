/**
 * One level of the ground's clipmap on the processor: heights on a lattice about a middle, kept in place while the
 * middle moves (texel = lattice index mod size), so that only what came into sight is computed.
 */
import { DataUtils } from "three";
import type { Terrain } from "../../world/terrain_type";

/** Points along a side of a level. */
export const CLIP_SIZE = 256;
/** Points along a side of the coarser lattice that holds cover and kinds of snow. */
export const KIND_SIZE = CLIP_SIZE / 2;
/** Levels move by this many points at once (even): few uploads, and no more than some milliseconds of heights. */
const STEP = 4;

/** A rectangle of lattice points: columns from i0 to before i1, rows from j0 to before j1. */
export type Rectangle = readonly [i0: number, i1: number, j0: number, j1: number];

/** What a square of `size` points at (i, j) covers that one at (oldI, oldJ) did not: up to two rectangles. */
export function uncovered(
  size: number,
  old: readonly [number, number] | null,
  i: number,
  j: number,
): Rectangle[] {
  const all: Rectangle = [i, i + size, j, j + size];
  if (!old) return [all];
  const [di, dj] = [i - old[0], j - old[1]];
  if (Math.abs(di) >= size || Math.abs(dj) >= size) return [all];
  const parts: Rectangle[] = [];
  if (dj > 0) parts.push([i, i + size, j + size - dj, j + size]);
  if (dj < 0) parts.push([i, i + size, j, j - dj]);
  const [j0, j1] = dj > 0 ? [j, j + size - dj] : [j - dj, j + size];
  if (di > 0) parts.push([i + size - di, i + size, j0, j1]);
  if (di < 0) parts.push([i, i - di, j0, j1]);
  return parts;
}

/** Where a level keeps its numbers: row by row of z, at texel (i mod size, j mod size). */
export interface LevelData {
  /** Heights [m]. */
  readonly heights: Float32Array;
  /** Gradients [dh/dx, dh/dz] as half floats. */
  readonly slopes: Uint16Array;
  /** Cover / 2, packed share, ice share, of 255; the fourth is not used. */
  readonly kinds: Uint8Array;
}

export class ClipLevel {
  readonly spacing: number;
  private readonly terrain: Terrain;
  private readonly data: LevelData;
  private corner: [number, number] | null = null;

  /** `spacing`: distance of the points [m]. */
  constructor(terrain: Terrain, spacing: number, data: LevelData) {
    this.terrain = terrain;
    this.spacing = spacing;
    this.data = data;
  }

  /** Middle of what is held [m]. */
  get middle(): [number, number] {
    const [i, j] = this.corner ?? [0, 0];
    return [(i + CLIP_SIZE / 2) * this.spacing, (j + CLIP_SIZE / 2) * this.spacing];
  }

  /** Move the middle near (x, z) [m]; false if it was near enough already. */
  move(x: number, z: number): boolean {
    const snap = (v: number) => Math.round(v / this.spacing / STEP) * STEP - CLIP_SIZE / 2;
    const [i, j] = [snap(x), snap(z)];
    if (this.corner && this.corner[0] === i && this.corner[1] === j) return false;
    const parts = uncovered(CLIP_SIZE, this.corner, i, j);
    this.corner = [i, j];
    for (const part of parts) this.fill(part);
    for (const part of parts) this.incline(part, i, j);
    return true;
  }

  /** Ask the terrain anew for cover and kinds of all that is held. */
  repaint(): void {
    if (!this.corner) return;
    const [i0, j0] = this.corner; // even, as all corners
    for (let j = j0; j < j0 + CLIP_SIZE; j += 2)
      for (let i = i0; i < i0 + CLIP_SIZE; i += 2) this.paint(i, j);
  }

  private fill([i0, i1, j0, j1]: Rectangle): void {
    const { terrain, spacing } = this;
    const { heights } = this.data;
    const mask = CLIP_SIZE - 1;
    for (let j = j0; j < j1; j++) {
      const row = (j & mask) * CLIP_SIZE;
      for (let i = i0; i < i1; i++) {
        heights[row + (i & mask)] = terrain.height(i * spacing, j * spacing);
        if (((i | j) & 1) === 0) this.paint(i, j);
      }
    }
  }

  /** Cover and kinds at a point with even numbers. */
  private paint(i: number, j: number): void {
    const { terrain, spacing } = this;
    const { kinds } = this.data;
    const mask = CLIP_SIZE - 1;
    const at = 4 * (((j & mask) >> 1) * KIND_SIZE + ((i & mask) >> 1));
    const [x, z] = [i * spacing, j * spacing];
    const [, packed, ice] = terrain.kinds(x, z);
    kinds[at] = Math.min(255, terrain.cover(x, z) * 127.5);
    kinds[at + 1] = packed * 255;
    kinds[at + 2] = ice * 255;
    kinds[at + 3] = 255;
  }

  /** Gradients by central differences; one-sided at the edge of what is held. */
  private incline([i0, i1, j0, j1]: Rectangle, left: number, top: number): void {
    const { heights, slopes } = this.data;
    const mask = CLIP_SIZE - 1;
    const [right, bottom] = [left + mask, top + mask];
    const at = (i: number, j: number) => heights[(j & mask) * CLIP_SIZE + (i & mask)]!;
    for (let j = Math.max(top, j0 - 1); j <= Math.min(bottom, j1); j++) {
      const [north, south] = [Math.max(top, j - 1), Math.min(bottom, j + 1)];
      for (let i = Math.max(left, i0 - 1); i <= Math.min(right, i1); i++) {
        const [west, east] = [Math.max(left, i - 1), Math.min(right, i + 1)];
        const texel = 2 * ((j & mask) * CLIP_SIZE + (i & mask));
        const dx = (at(east, j) - at(west, j)) / ((east - west) * this.spacing);
        const dz = (at(i, south) - at(i, north)) / ((south - north) * this.spacing);
        slopes[texel] = DataUtils.toHalfFloat(dx);
        slopes[texel + 1] = DataUtils.toHalfFloat(dz);
      }
    }
  }
}
