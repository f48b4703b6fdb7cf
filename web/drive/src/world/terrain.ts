/**
 * The ground of an endless world: the landscape taken at the points of a lattice, straight between them, so that
 * shaders, wheels and colliders that read the same lattice have exactly the same ground.
 */
import type { Snowed } from "../bridge/ground";
import { Landscape, LAKE_LEVEL } from "./landscape";
import { random, smoothstep } from "./noise";
import { SnowedLand } from "./snowed_land";
import type { Land, Surface, Terrain } from "./terrain_type";

/** Distance of neighbouring lattice points [m]. */
export const SPACING = 0.5;

/** A terrain that also gives its lattice: `height` is bilinear between `lattice(i, j)` at (i, j) * SPACING. */
export interface LatticeTerrain extends Terrain {
  /** Height of lattice point (i, j) [m], a number that float32 holds exactly. */
  lattice(i: number, j: number): number;
}

// Points that were asked for lately, one for each slot: 2^17 points are 181 m square, more than cars and shaders touch
// between two visits of the same place.
const SLOTS = 1 << 17;
const ROW = 362;

/** Numbers that belong to lattice points, kept for as long as no other point needs their place. */
class Memory {
  readonly values: Float32Array;
  private readonly size: number;
  private readonly columns = new Int32Array(SLOTS).fill(0x7fffffff);
  private readonly rows = new Int32Array(SLOTS);
  private readonly fill: (i: number, j: number, at: number) => void;

  /** `fill` puts `size` numbers of point (i, j) into `values`, from index `at`. */
  constructor(size: number, fill: (i: number, j: number, at: number) => void) {
    this.size = size;
    this.values = new Float32Array(size * SLOTS);
    this.fill = fill;
  }

  /** Index of the first number of a point. */
  find(i: number, j: number): number {
    const slot = (Math.imul(j, ROW) + i) & (SLOTS - 1);
    const at = slot * this.size;
    if (this.columns[slot] !== i || this.rows[slot] !== j) {
      this.columns[slot] = i;
      this.rows[slot] = j;
      this.fill(i, j, at);
    }
    return at;
  }
}

/** Where the surface of a point's numbers is kept: cover, share of packed snow, share of ice. */
const COVER = 0;
const PACKED = 1;
const ICE = 2;

class LatticeLand implements LatticeTerrain {
  private readonly heights: Memory;
  private readonly surfaces: Memory;

  constructor(land: Land) {
    this.heights = new Memory(1, (i, j, at) => {
      this.heights.values[at] = land.height(i * SPACING, j * SPACING);
    });
    this.surfaces = new Memory(3, (i, j, at) => {
      this.surfaces.values.set(land.surface(i * SPACING, j * SPACING), at);
    });
  }

  lattice(i: number, j: number): number {
    return this.heights.values[this.heights.find(i, j)]!;
  }

  height(x: number, z: number): number {
    return this.between(this.heights, 0, x, z);
  }

  slope(x: number, z: number): [number, number] {
    const i = Math.floor(x / SPACING);
    const j = Math.floor(z / SPACING);
    const u = x / SPACING - i;
    const v = z / SPACING - j;
    const [a, b] = [this.lattice(i, j), this.lattice(i + 1, j)];
    const [c, d] = [this.lattice(i, j + 1), this.lattice(i + 1, j + 1)];
    return [((b - a) * (1 - v) + (d - c) * v) / SPACING, ((c - a) * (1 - u) + (d - b) * u) / SPACING];
  }

  cover(x: number, z: number): number {
    return this.between(this.surfaces, COVER, x, z);
  }

  kinds(x: number, z: number): [number, number, number] {
    const packed = this.between(this.surfaces, PACKED, x, z);
    const ice = this.between(this.surfaces, ICE, x, z);
    return [Math.max(0, 1 - packed - ice), packed, ice];
  }

  private between(memory: Memory, offset: number, x: number, z: number): number {
    const i = Math.floor(x / SPACING);
    const j = Math.floor(z / SPACING);
    const u = x / SPACING - i;
    const v = z / SPACING - j;
    const value = (column: number, row: number) => memory.values[memory.find(column, row) + offset]!;
    const a = value(i, j);
    // On the lines of the lattice two or three corners have no weight: coarse levels of detail pay for one.
    const near = u === 0 ? a : a + (value(i + 1, j) - a) * u;
    if (v === 0) return near;
    const c = value(i, j + 1);
    const far = u === 0 ? c : c + (value(i + 1, j + 1) - c) * u;
    return near + (far - near) * v;
  }
}

/** The land as it is: its snow held by slopes and roads, moved by the wind. */
class WildLand implements Land {
  private readonly land: Landscape;
  private readonly heights: Memory;

  constructor(land: Landscape) {
    this.land = land;
    this.heights = new Memory(1, (i, j, at) => {
      this.heights.values[at] = land.height(i * SPACING, j * SPACING);
    });
  }

  /** Height of the nearest point of the lattice [m]. */
  height(x: number, z: number): number {
    return this.heights.values[this.heights.find(Math.round(x / SPACING), Math.round(z / SPACING))]!;
  }

  surface(x: number, z: number): Surface {
    const { land } = this;
    // Slope over two metres: snow holds on a step of half a metre, not on a cliff.
    const east = this.height(x + 1, z) - this.height(x - 1, z);
    const south = this.height(x, z + 1) - this.height(x, z - 1);
    const holds = smoothstep(1.3, 0.7, Math.hypot(east, south) / 2);
    const road = land.road(x, z);
    const ice = land.ice(x, z) * (1 - road);
    const wind = land.wind(x, z);
    const crust = 0.5 * smoothstep(-0.25, -0.6, wind) * (1 - road - ice);
    const cover = holds * ((1 + 0.4 * wind) * (1 - road) * (1 - 0.85 * ice) + 0.45 * road);
    return [cover, road + crust, ice];
  }
}

/**
 * Terrain of a seed: the same for the same seed on every machine that has the same cosines. The start is (0, 0), where
 * `piece`, if there is one, takes the place of the hills.
 */
export function makeTerrain(seed: number, piece: Snowed | null = null): LatticeTerrain {
  const [east, south] = findStart(seed);
  const wild = new WildLand(new Landscape(seed, east, south));
  return new LatticeLand(piece ? new SnowedLand(wild, piece) : wild);
}

/** The best of some places to begin: level, on open snow, a road close by and a lake in sight. */
function findStart(seed: number): [number, number] {
  let best: [number, number] = [0, 0];
  let least = Infinity;
  for (let k = 0; k < 600; k++) {
    const place: [number, number] = [4000 * random(k, 0, seed + 41), 4000 * random(k, 1, seed + 41)];
    const cost = unease(new Landscape(seed, ...place));
    if (cost < least) [best, least] = [place, cost];
  }
  return best;
}

/** How far a place is from a good start: 0 is perfect. */
function unease(land: Landscape): number {
  const road = land.roadDistance(0, 0);
  let cost = Math.max(0, 18 - road) / 4 + Math.max(0, road - 30) / 15;
  if (cost > 6) return cost;
  const middle = land.height(0, 0);
  cost += 5 * Math.max(0, LAKE_LEVEL + 1.2 - middle);
  let lake = Infinity;
  for (let k = 0; k < 16; k++) {
    const [dx, dz] = [Math.cos((k * Math.PI) / 8), Math.sin((k * Math.PI) / 8)];
    for (const r of [6, 14]) cost += (4 * Math.abs(land.height(r * dx, r * dz) - middle)) / r;
    for (let r = 30; r < 200; r += 15) if (land.ice(r * dx, r * dz) > 0.9) lake = Math.min(lake, r);
  }
  return cost + Math.max(0, Math.min(lake, 300) - 90) / 20 + Math.max(0, 60 - lake) / 20;
}
