/**
 * The shape of the land as a formula of the place alone: rolling hills, roads along the zero line of a slow noise,
 * lakes wherever the land would lie below their level, outcrops of rock, and mountains far from the start that
 * leave the valleys of the roads open.
 */
import { mix, noise, noiseWithSlope, ridges, smoothstep, type Sample } from "./noise";

/** Level of the ice of every lake [m]. */
export const LAKE_LEVEL = -3.5;
/** Half the width of a road where the snow is packed, and where its embankment has met the land [m]. */
const ROAD_PACKED = 3.2;
const ROAD_SHOULDER = 5;
const ROAD_BLENDED = 16;
const ROAD_WAVE = 430;
const ROAD_BENDS = 150;

/** Where a place is with respect to the nearest road. */
interface Road {
  /** Distance from its middle [m], to first order. */
  distance: number;
  /** Foot of the perpendicular. */
  x: number;
  z: number;
  /** The slow noise itself: 0 on the road, about 1 at the ridge between two roads. */
  apart: number;
}

export class Landscape {
  private readonly seed: number;
  private readonly east: number;
  private readonly south: number;
  private readonly slow: Sample = { value: 0, dx: 0, dz: 0 };
  private readonly bends: Sample = { value: 0, dx: 0, dz: 0 };
  private readonly near: Road = { distance: 0, x: 0, z: 0, apart: 0 };

  /** `east`, `south` [m] move the formula so that a chosen place of it becomes the start (0, 0). */
  constructor(seed: number, east = 0, south = 0) {
    this.seed = seed;
    this.east = east;
    this.south = south;
  }

  /** Height of the ground [m]; (x, z) as the world has them. */
  height(x: number, z: number): number {
    return smoothFloor(this.dryHeight(x, z), LAKE_LEVEL, 0.8);
  }

  /** Share of road, 0..1, at a place. */
  road(x: number, z: number): number {
    return smoothstep(ROAD_SHOULDER, ROAD_PACKED, this.roadAt(x, z).distance);
  }

  /** Share of ice, 0..1: 1 where the lake is flat, 0 on dry land. */
  ice(x: number, z: number): number {
    return smoothstep(LAKE_LEVEL + 0.1, LAKE_LEVEL - 0.8, this.dryHeight(x, z));
  }

  /** Distance to the middle of the nearest road [m], to first order. */
  roadDistance(x: number, z: number): number {
    return this.roadAt(x, z).distance;
  }

  /** How much the wind has taken (-1) or brought (1). */
  wind(x: number, z: number): number {
    const [px, pz] = [x + this.east, z + this.south];
    return 0.6 * noise(px / 47, pz / 47, this.seed + 31) + 0.4 * noise(px / 15, pz / 15, this.seed + 32);
  }

  /** Height if there were no lakes [m]. */
  private dryHeight(x: number, z: number): number {
    const [px, pz, seed] = [x + this.east, z + this.south, this.seed];
    const road = this.roadAt(x, z);
    const wild = smoothstep(ROAD_SHOULDER, ROAD_BLENDED, road.distance);
    const level = this.hills(road.x, road.z);
    if (wild === 0) return level;
    let land = this.hills(px, pz);
    land += 1.5 * noise(px / 38, pz / 38, seed + 3) + 0.3 * noise(px / 13, pz / 13, seed + 4);
    land += 0.05 * noise(px / 4.3, pz / 4.3, seed + 5);
    const far = Math.hypot(x, z);
    land += smoothstep(25, 60, far) * this.rock(px, pz) * smoothstep(10, 25, road.distance);
    const open = smoothstep(0.1, 0.9, road.apart) * smoothstep(180, 800, far);
    if (open > 0) {
      land += open * (20 + 230 * ridges(px / 620, pz / 620, seed + 11, 5));
    }
    return mix(level, land, wild);
  }

  private hills(px: number, pz: number): number {
    return 9 * noise(px / 210, pz / 210, this.seed + 1) + 3.5 * noise(px / 87, pz / 87, this.seed + 2);
  }

  /** Outcrops: steep at their edge, broken on top [m]. */
  private rock(px: number, pz: number): number {
    const where = noise(px / 73, pz / 73, this.seed + 7) + 0.3 * noise(px / 17, pz / 17, this.seed + 8);
    const share = smoothstep(0.62, 0.74, where);
    return share === 0 ? 0 : share * (5 + 3 * noise(px / 8, pz / 8, this.seed + 9));
  }

  private roadAt(x: number, z: number): Road {
    const [px, pz, road] = [x + this.east, z + this.south, this.near];
    const a = noiseWithSlope(px / ROAD_WAVE, pz / ROAD_WAVE, this.seed + 21, this.slow);
    const b = noiseWithSlope(px / ROAD_BENDS, pz / ROAD_BENDS, this.seed + 22, this.bends);
    const value = a.value + 0.2 * b.value;
    const gx = a.dx / ROAD_WAVE + (0.2 * b.dx) / ROAD_BENDS;
    const gz = a.dz / ROAD_WAVE + (0.2 * b.dz) / ROAD_BENDS;
    // One step of Newton's method to the zero line. Near a saddle the gradient vanishes: the floor keeps the foot
    // of the perpendicular within reach, and two roads that meet there get a wide junction.
    const g = gx * gx + gz * gz + 1e-7;
    road.distance = Math.abs(value) / Math.sqrt(g);
    road.x = px - (value * gx) / g;
    road.z = pz - (value * gz) / g;
    road.apart = Math.abs(value);
    return road;
  }
}

/** The larger of x and floor, rounded within `width` of the place where they meet; exactly `floor` below that. */
function smoothFloor(x: number, floor: number, width: number): number {
  const above = x - floor + width;
  if (above <= 0) return floor;
  return above >= 2 * width ? x : floor + (above * above) / (4 * width);
}
