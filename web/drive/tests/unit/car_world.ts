/** Worlds for tests of the car: level or tilted ground under one type of snow, with or without ruts that were pressed before. */
import type { CarOptions } from "../../src/car/vehicle";
import { defaults } from "../../src/settings";
import type { Terrain } from "../../src/world/terrain_type";

/** Ground that rises by `east` and `south` per metre, under snow of the given shares of types. */
export function plain(kinds: [number, number, number], east = 0, south = 0): Terrain {
  return {
    height: (x, z) => east * x + south * z,
    slope: () => [east, south],
    cover: () => 1,
    kinds: () => kinds,
  };
}

export const POWDER: [number, number, number] = [1, 0, 0];
export const PACKED: [number, number, number] = [0, 1, 0];
export const ICE: [number, number, number] = [0, 0, 1];

/** What Car.create wants, with fresh snow of a depth [m] everywhere. */
export function options(
  terrain: Terrain,
  depth: number,
  changes: Partial<CarOptions["settings"]> = {},
): CarOptions {
  return { terrain, snow: () => ({ h: depth, W: depth }), settings: { ...defaults(), ...changes } };
}
