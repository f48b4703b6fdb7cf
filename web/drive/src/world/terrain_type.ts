/** What the ground is at a place: the interface between terrain, car, snow and picture. x east, y up, z south [m]. */
export interface Terrain {
  /** Height of the ground below the snow [m]. */
  height(x: number, z: number): number;
  /** Gradient of that height: [dh/dx, dh/dz]. */
  slope(x: number, z: number): [number, number];
  /** Depth of fresh snow as a factor of the depth in the settings, 0 (bare: steep, wind-swept) to about 1.5. */
  cover(x: number, z: number): number;
  /** Shares of the snow types [powder, packed, ice], each 0..1, sum 1. */
  kinds(x: number, z: number): [number, number, number];
}

/** Cover, share of packed snow, share of ice at a place: see `Terrain`. */
export type Surface = readonly [number, number, number];

/** What a lattice of terrain is filled from: height of the ground [m] and surface at its points. */
export interface Land {
  height(x: number, z: number): number;
  surface(x: number, z: number): Surface;
}

/** Level ground at height 0 under even powder. */
export const LEVEL: Terrain = {
  height: () => 0,
  slope: () => [0, 0],
  cover: () => 1,
  kinds: () => [1, 0, 0],
};
