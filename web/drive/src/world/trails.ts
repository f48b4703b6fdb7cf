/** Where people and animals have walked: chosen by hashes of tiles of the world, the same in every visit. Pure. */
import { footStamps } from "../snow/foot";
import type { Stamp } from "../snow/stamps";
import { noise, random } from "./noise";
import { TILE } from "./places";
import type { Terrain } from "./terrain_type";

/** A step: the stamps of one foot, or of the paws of a leap, and where. */
export interface Step {
  readonly x: number;
  readonly z: number;
  /** What presses there, when fresh snow is `fresh` [m] deep over ground of the height `ground` [m]. */
  stamps(ground: number, fresh: number): Stamp[];
}

type Gait = (x: number, z: number, heading: number, count: number) => Step;
interface Walker {
  readonly stride: number; // m
  readonly steps: number;
  readonly chance: number; // of one in a tile
  readonly gait: Gait;
}

/** A box as a paw presses it. */
const paw = (x: number, y: number, z: number, heading: number, length: number, width: number): Stamp => ({
  shape: "box",
  ...{ x, y, z, heading, length, width },
  slopeAlong: 0,
  slopeAcross: 0,
});

/** Somebody on foot: left and right in turn, knee-deep in loose snow. */
const person: Gait = (x, z, heading, count) => {
  const side = count % 2 ? 0.12 : -0.12;
  const [px, pz] = [x - side * Math.sin(heading), z + side * Math.cos(heading)];
  const foot = { x: px, z: pz, heading, length: 0.3, width: 0.13 };
  return { x: px, z: pz, stamps: (ground, fresh) => footStamps({ ...foot, y: ground + 0.45 * fresh }) };
};

/** A deer: one narrow deep print each step, nearly in a line. */
const deer: Gait = (x, z, heading, count) => {
  const side = count % 2 ? 0.07 : -0.07;
  const [px, pz] = [x - side * Math.sin(heading), z + side * Math.cos(heading)];
  return {
    x: px,
    z: pz,
    stamps: (ground, fresh) => [paw(px, ground + 0.35 * fresh, pz, heading, 0.14, 0.1)],
  };
};

/** A hare in leaps: both hind feet side by side before the fore feet, one behind the other. */
const hare: Gait = (x, z, heading) => {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const at = (along: number, across: number) =>
    [x + c * along - s * across, z + s * along + c * across] as const;
  const feet = [
    [0.2, 0.08, 0.15, 0.07],
    [0.2, -0.08, 0.15, 0.07],
    [-0.02, 0.02, 0.08, 0.06],
    [-0.16, -0.02, 0.08, 0.06],
  ] as const;
  return {
    x,
    z,
    stamps: (ground, fresh) =>
      feet.map(([along, across, length, width]) => {
        const [px, pz] = at(along, across);
        return paw(px, ground + Math.max(0.5 * fresh, fresh - 0.09), pz, heading, length, width);
      }),
  };
};

const WALKERS: readonly Walker[] = [
  { stride: 0.72, steps: 110, chance: 0.45, gait: person },
  { stride: 0.62, steps: 130, chance: 0.6, gait: deer },
  { stride: 1.25, steps: 60, chance: 0.9, gait: hare },
];

/** Trails that pass the start of the world, so that one is in sight there: kind, place [m] and course [rad]. */
const AT_START = [
  { kind: 0, x: -18, z: 9, course: 0.15 },
  { kind: 2, x: 14, z: -13, course: 2.6 },
] as const;

/** The steps on tile (i, j), and a little beyond it; none where snow is thin, on roads or on ice. */
export function trailsOf(terrain: Terrain, i: number, j: number, seed: number): Step[] {
  const own = WALKERS.flatMap(({ chance }, kind) => {
    const dice = (salt: number) => random(i, j, seed + 61 + 17 * kind + salt);
    if (dice(0) > chance) return [];
    const [x, z] = [(i + 0.15 + 0.7 * dice(1)) * TILE, (j + 0.15 + 0.7 * dice(2)) * TILE];
    return [{ kind, x, z, course: 2 * Math.PI * dice(3) }];
  });
  const all = i === 0 && j === 0 ? [...AT_START, ...own] : own;
  return all.flatMap((trail) => walked(terrain, trail, seed));
}

/** The steps of one trail, which winds about its course. */
function walked(
  terrain: Terrain,
  trail: { kind: number; x: number; z: number; course: number },
  seed: number,
): Step[] {
  const { stride, steps, gait } = WALKERS[trail.kind]!;
  let { x, z } = trail;
  const found: Step[] = [];
  for (let count = 0; count < steps; count++) {
    const heading = trail.course + 1.3 * noise(x / 23, z / 23, seed + 71 + trail.kind);
    [x, z] = [x + stride * Math.cos(heading), z + stride * Math.sin(heading)];
    const [powder] = terrain.kinds(x, z);
    if (powder > 0.7 && terrain.cover(x, z) > 0.5) found.push(gait(x, z, heading, count));
  }
  return found;
}
