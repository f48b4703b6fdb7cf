/**
 * Where trees, rocks and poles stand: chosen by hashes of cells of the world, the same in every visit, without a list
 * of the world.
 */
import type { Terrain } from "./terrain_type";
import { random } from "./noise";

export interface Place {
  readonly x: number;
  readonly y: number;
  readonly z: number;
  /** Height of a tree, width of a rock [m]. */
  readonly size: number;
  /** Turn about y [rad]. */
  readonly turn: number;
  /** 0..1, the same for the same thing at every visit: what thins them out far away. */
  readonly rank: number;
}

export interface Places {
  readonly trees: readonly Place[];
  readonly rocks: readonly Place[];
  readonly poles: readonly Place[];
}

/** Side of a tile [m] and cells along it. */
export const TILE = 96;
const CELLS = 16;
/** No tree, rock or pole nearer to the start than this [m]. */
export const CLEARING = 11;

function smooth(x: number, z: number, scale: number, salt: number): number {
  const [u, v] = [x / scale, z / scale];
  const [i, j] = [Math.floor(u), Math.floor(v)];
  const ease = (t: number) => t * t * (3 - 2 * t);
  const [s, t] = [ease(u - i), ease(v - j)];
  const row = (k: number) => random(i, k, salt) * (1 - s) + random(i + 1, k, salt) * s;
  return row(j) * (1 - t) + row(j + 1) * t;
}

/** How much of a wood there is at a place, 0..1. */
export function woodland(x: number, z: number, seed: number): number {
  const broad = 0.62 * smooth(x, z, 170, seed + 3) + 0.38 * smooth(x, z, 47, seed + 4);
  return Math.min(1, Math.max(0, (broad - 0.47) / 0.2));
}

/** What stands on tile (i, j), nothing where a place is not `free`. */
export function placesOf(
  terrain: Terrain,
  i: number,
  j: number,
  seed: number,
  free: (x: number, z: number) => boolean = () => true,
): Places {
  const trees: Place[] = [];
  const rocks: Place[] = [];
  const poles: Place[] = [];
  const cell = TILE / CELLS;
  for (let k = 0; k < CELLS * CELLS; k++) {
    const [ci, cj] = [i * CELLS + (k % CELLS), j * CELLS + Math.floor(k / CELLS)];
    const x = (ci + 0.15 + 0.7 * random(ci, cj, seed)) * cell;
    const z = (cj + 0.15 + 0.7 * random(ci, cj, seed + 1)) * cell;
    if (Math.hypot(x, z) < CLEARING) continue;
    if (!free(x, z)) continue;
    const chance = random(ci, cj, seed + 2);
    const wood = woodland(x, z, seed);
    // A few stand alone in the open.
    if (chance < 0.03 + 0.75 * wood) addTree(trees, terrain, x, z, ci, cj, seed, wood);
    else if (chance > 0.93) addRock(rocks, terrain, x, z, ci, cj, seed);
    if ((ci + cj) % 2 === 0) addPole(poles, terrain, ci * cell, cj * cell, cell, seed);
  }
  return { trees, rocks, poles };
}

/** True where nothing of a tree's width stands on a road, on ice or on a cliff. */
export function treeMayStand(terrain: Terrain, x: number, z: number): boolean {
  const free = ([dx, dz]: readonly [number, number]) => {
    const [powder, packed, ice] = terrain.kinds(x + dx, z + dz);
    return powder > 0.4 && ice < 0.02 && packed < 0.55;
  };
  if (
    !free([0, 0]) ||
    !(
      [
        [2.6, 0],
        [-2.6, 0],
        [0, 2.6],
        [0, -2.6],
      ] as const
    ).every(free)
  )
    return false;
  const [a, b] = terrain.slope(x, z);
  return Math.hypot(a, b) < 0.62 && terrain.cover(x, z) > 0.45;
}

function addTree(
  to: Place[],
  terrain: Terrain,
  x: number,
  z: number,
  ci: number,
  cj: number,
  seed: number,
  wood: number,
): void {
  if (!treeMayStand(terrain, x, z)) return;
  const tall = random(ci, cj, seed + 5);
  const young = random(ci, cj, seed + 6) < 0.2 ? 0.45 : 1;
  const size = (4.2 + 7.5 * tall ** 1.3 + 2.5 * wood) * young;
  const place = { x, y: terrain.height(x, z) - 0.1, z, size };
  to.push({ ...place, turn: 6.283 * random(ci, cj, seed + 7), rank: random(ci, cj, seed + 8) });
}

function addRock(
  to: Place[],
  terrain: Terrain,
  x: number,
  z: number,
  ci: number,
  cj: number,
  seed: number,
): void {
  const [, packed, ice] = terrain.kinds(x, z);
  if (packed > 0.2 || ice > 0.05) return;
  const [a, b] = terrain.slope(x, z);
  const steep = Math.min(1, Math.hypot(a, b) / 0.8);
  const kind = random(ci, cj, seed + 9);
  if (kind > 0.25 + 0.75 * steep) return;
  const size = 0.5 + 2.1 * random(ci, cj, seed + 10) ** 2 * (0.5 + steep);
  to.push({ x, y: terrain.height(x, z), z, size, turn: 6.283 * kind * 4, rank: random(ci, cj, seed + 11) });
}

/** A pole where the edge of a road passes through a cell; one for each cell at most. */
function addPole(to: Place[], terrain: Terrain, x0: number, z0: number, cell: number, seed: number): void {
  for (let k = 0; k < 9; k++) {
    const [x, z] = [x0 + ((k % 3) + 0.5) * (cell / 3), z0 + (Math.floor(k / 3) + 0.5) * (cell / 3)];
    if (Math.hypot(x, z) < CLEARING) continue;
    // Crust of the wind is half packed: only a place beside a real road is its edge.
    const packed = terrain.kinds(x, z)[1];
    if (packed < 0.02 || packed > 0.3) continue;
    const beside = [2.2, -2.2].some(
      (d) => terrain.kinds(x + d, z)[1] > 0.9 || terrain.kinds(x, z + d)[1] > 0.9,
    );
    if (!beside) continue;
    to.push({
      x,
      y: terrain.height(x, z),
      z,
      size: 1,
      turn: random(k, Math.round(x0), seed) * 6.283,
      rank: 0,
    });
    return;
  }
}
