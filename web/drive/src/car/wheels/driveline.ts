/** How the forces that the driver asks for come to the four wheels. */
import { GRAVITY, WHEELS } from "../body";
import type { Demand } from "./gearbox";
import { slidingGrip } from "./tyre";

/** Torque by which limited-slip differentials bring driven wheels together [N m s], and at most [N m]. */
const COUPLING = 30;
const COUPLING_MOST = 250;
/** Share of the brake force at the front wheels. */
const FRONT_BRAKES = 0.6;
/** Brake force of the handbrake on each rear wheel as a share of the car's weight: more than any snow can hold. */
const HANDBRAKE = 0.3;
/** The anti-lock brake asks for no more than this share of the grip, above this speed [m/s]. */
const ANTI_LOCK = 0.92;
const ANTI_LOCK_SPEED = 1.5;

/** The engine gives a wheel what it can hold and so much more [N m]; at this slip [m/s] nothing more. */
const EXCESS = 150;
const EXCESS_SLIP = 3.5;

export interface WheelNow {
  readonly omega: number; // rad/s
  readonly slip: number; // m/s
  readonly load: number; // N
  readonly friction: number;
}

export interface Torque {
  drive: number; // N m
  brake: number; // N m, the most the brake can give
}

/** Whether wheel `index` is driven. */
export function driven(index: number, drive: "all" | "front" | "rear"): boolean {
  return drive === "all" || (drive === "front") === WHEELS[index]!.front;
}

/** Mean speed of rotation of the driven wheels [rad/s]. */
export function drivenSpeed(omegas: readonly number[], drive: "all" | "front" | "rear"): number {
  const those = omegas.filter((_, i) => driven(i, drive));
  return those.reduce((sum, omega) => sum + omega, 0) / those.length;
}

/** Torques of the four wheels. */
export function share(
  demand: Demand,
  handbrake: number,
  speed: number,
  wheels: readonly WheelNow[],
  car: { mass: number; radius: number; drive: "all" | "front" | "rear" },
): Torque[] {
  const omegas = wheels.map(({ omega }) => omega);
  const mean = drivenSpeed(omegas, car.drive);
  const count = wheels.filter((_, i) => driven(i, car.drive)).length;
  return wheels.map(({ omega, slip, load, friction }, i) => {
    const coupled = Math.min(COUPLING_MOST, Math.max(-COUPLING_MOST, COUPLING * (mean - omega)));
    const asked = (demand.drive * car.radius) / count;
    const held =
      friction * slidingGrip(slip) * load * car.radius + EXCESS * (1 - Math.abs(slip) / EXCESS_SLIP);
    const given = Math.sign(asked) * Math.min(Math.abs(asked), Math.max(held, 0));
    const drive = driven(i, car.drive) ? given + coupled : 0;
    const part = (WHEELS[i]!.front ? FRONT_BRAKES : 1 - FRONT_BRAKES) / 2;
    let brake = demand.brake * part * car.radius;
    if (Math.abs(speed) > ANTI_LOCK_SPEED) brake = Math.min(brake, ANTI_LOCK * friction * load * car.radius);
    if (!WHEELS[i]!.front) brake += handbrake * HANDBRAKE * car.mass * GRAVITY * car.radius;
    return { drive, brake };
  });
}
