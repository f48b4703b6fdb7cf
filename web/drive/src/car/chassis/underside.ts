/** The forces of snow on the underside of the whole car, patch by patch. */
import type { SnowType } from "../../snow/types";
import { lift, plough, rubbing } from "./belly";
import { BODY, GRAVITY } from "../body";
import type { Chassis } from "./chassis";
import type { Surroundings } from "../wheels/footing";
import { add, scale, turn, unit, type Vec } from "../geometry";

const ALONG = [-1.75, -0.6, 0.6, 1.75] as const;
const ACROSS = [-0.55, 0.55] as const;
const AREA = (BODY.length * BODY.width) / (ALONG.length * ACROSS.length);
/** How far before the car's edge the snow is looked at that it is about to plough [m]. */
const BEFORE = 0.15;
/** Damping of a patch that lies on snow, as a rate of the car's mass [1/s]. */
const DAMPING = 0.8;

/** Let the snow act on the underside for one step; returns how deep it is below the surface at most [m]. */
export function pushUnderside(
  chassis: Chassis,
  where: Surroundings,
  types: readonly SnowType[],
  mass: number,
  step: number,
): number {
  const { position, rotation, velocity } = chassis;
  const forward = turn(rotation, [1, 0, 0]);
  const speed = forward[0] * velocity[0] + forward[1] * velocity[1] + forward[2] * velocity[2];
  const velocityAt = chassis.motion();
  let deepest = 0;
  // The snow cannot do more than stop the car: no force above what takes this share of its speed in a step.
  const most = (0.1 * mass * Math.abs(speed)) / step;
  const place = (x: number, z: number) => add(position, turn(rotation, [x, -BODY.underside, z]));
  for (const x of ALONG) {
    for (const z of ACROSS) {
      const at = place(x, z);
      const ground = where.terrain.height(at[0], at[2]);
      const column = where.snow(at[0], at[2]);
      const type = types[(x > 0 ? 0 : 2) + (z > 0 ? 1 : 0)]!;
      const clearance = at[1] - ground;
      const patch = { column, type, compaction: where.compaction, clearance, area: AREA };
      const up = Math.min(lift(patch), 0.3 * mass * GRAVITY);
      const moves = velocityAt(at);
      if (up > 0) {
        const rub = Math.min(rubbing(up), most);
        const against = scale(
          unit([moves[0], 0, moves[2]]),
          -rub * Math.tanh(Math.hypot(moves[0], moves[2])),
        );
        chassis.push([against[0], Math.max(0, up - DAMPING * mass * moves[1]), against[2]], at);
      }
      deepest = Math.max(deepest, column.h - clearance);
      if (Math.abs(x) < 1 || x * speed <= 0) continue;
      deepest = Math.max(
        deepest,
        ploughEdge(chassis, where, type, place(Math.sign(x) * (2 + BEFORE), z), forward, speed, most),
      );
    }
  }
  return Math.max(0, deepest);
}

/** Half of the leading edge; returns how deep it ploughs [m]. */
function ploughEdge(
  chassis: Chassis,
  { terrain, snow }: Surroundings,
  type: SnowType,
  at: Vec,
  forward: Vec,
  speed: number,
  most: number,
): number {
  const deep = terrain.height(at[0], at[2]) + snow(at[0], at[2]).h - at[1];
  const force = Math.min(plough(type, BODY.width / 2, deep, Math.abs(speed)), most);
  if (force > 0) chassis.push(scale(forward, -force * Math.tanh(speed)), at);
  return deep;
}
