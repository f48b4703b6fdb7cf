import type { Terrain } from "../../world/terrain_type";
import { COVER_SIDE, COVER_STEP } from "../gpu/shaders";
import { TILE } from "./tiles";

/** The cover of a tile on its coarse lattice, rows of z: what the shader mixes the fresh depth from. */
export function coverLattice(terrain: Terrain, tx: number, tz: number, texel: number): Float32Array {
  const lattice = new Float32Array(COVER_SIDE * COVER_SIDE);
  for (let j = 0; j < COVER_SIDE; j++)
    for (let i = 0; i < COVER_SIDE; i++)
      lattice[i + COVER_SIDE * j] = terrain.cover(
        (tx * TILE + i * COVER_STEP) * texel,
        (tz * TILE + j * COVER_STEP) * texel,
      );
  return lattice;
}

/** Cover at a texel of a tile, between the points of its lattice, as the shader has it up to rounding. */
export function coverAt(lattice: Float32Array, x: number, z: number): number {
  const [px, pz] = [(x + 0.5) / COVER_STEP, (z + 0.5) / COVER_STEP];
  const [i, j] = [Math.floor(px), Math.floor(pz)];
  const value = (di: number, dj: number) => lattice[i + di + COVER_SIDE * (j + dj)]!;
  const [u, v] = [px - i, pz - j];
  const near = value(0, 0) * (1 - u) + value(1, 0) * u;
  return near * (1 - v) + (value(0, 1) * (1 - u) + value(1, 1) * u) * v;
}

/** Whether a tile, (h, W) pairs, holds nothing but fresh snow: then there is nothing to keep. */
export function onlyFresh(data: Float32Array, lattice: Float32Array, depth: number): boolean {
  for (let z = 0; z < TILE; z++)
    for (let x = 0; x < TILE; x++) {
      const fresh = depth * coverAt(lattice, x, z);
      const at = 2 * (x + TILE * z);
      // Rounding of the mixing in float32 is below 1e-6; tracks are a thousand times as deep.
      if (Math.abs(data[at]! - fresh) > 1e-5 || Math.abs(data[at + 1]! - fresh) > 1e-5) return false;
    }
  return true;
}
