/** The car as others see it: drawn, followed by the camera, pressed into the snow. */
import { BODY } from "./body";
import { add, between, betweenTurns, turn, type Quaternion, type Vec } from "./geometry";
import type { BoxStamp, Place, WheelStamp } from "../snow/stamps";

export interface WheelState {
  /** Middle of the wheel [m]. */
  centre: Vec;
  /** Steering angle about the upward axis of the car, positive to the left, and angle rolled [rad]. */
  steer: number;
  spin: number;
  radius: number; // m
  width: number; // m
  load: number; // N
  slip: number; // m/s, circumference minus ground
  sinkage: number; // m
  /** Sideways force of the ground, positive to the right [N]. */
  sideForce: number;
  grounded: boolean;
}

export interface CarState {
  /** Centre of mass [m]. */
  position: Vec;
  rotation: Quaternion;
  velocity: Vec; // m/s
  angular: Vec; // rad/s
  /** Forward speed [m/s], negative backwards. */
  speed: number;
  /** Front left, front right, rear left, rear right. */
  wheels: WheelState[];
  /** "R" or "1" .. "6". */
  gear: string;
  /** Speed of the engine, 0..1. */
  revs: number;
  /** Power that the engine gives to the wheels [W]. */
  enginePower: number;
  /** How deep the underside is below the surface of the snow at most [m]; 0 when it is free. */
  ploughing: number;
}

/** State between two states, t = 0..1: what is drawn moves evenly though physics steps are of fixed length. */
export function interpolate(a: CarState, b: CarState, t: number): CarState {
  return {
    ...b,
    position: between(a.position, b.position, t),
    rotation: betweenTurns(a.rotation, b.rotation, t),
    velocity: between(a.velocity, b.velocity, t),
    speed: a.speed + (b.speed - a.speed) * t,
    wheels: b.wheels.map((wheel, i) => {
      const before = a.wheels[i]!;
      return {
        ...wheel,
        centre: between(before.centre, wheel.centre, t),
        steer: before.steer + (wheel.steer - before.steer) * t,
        spin: before.spin + (wheel.spin - before.spin) * t,
      };
    }),
  };
}

/** Direction of a vector on the map, as the stamps have it: (cos, sin) in (x, z). */
function headingOf([x, , z]: Readonly<Vec>): number {
  return Math.atan2(z, x);
}

/** The print of wheel `index`. */
export function wheelStamp(state: CarState, index: number, from: Place | undefined): WheelStamp {
  const wheel = state.wheels[index]!;
  const [x, y, z] = wheel.centre;
  const ahead = turn(state.rotation, [Math.cos(wheel.steer), 0, -Math.sin(wheel.steer)]);
  const { radius, width, slip } = wheel;
  return { shape: "wheel", x, y, z, heading: headingOf(ahead), radius, width, slip, ...(from && { from }) };
}

/** The print of the underside. */
export function bellyStamp(state: CarState, from: Place | undefined): BoxStamp {
  const [x, y, z] = add(state.position, turn(state.rotation, [0, -BODY.underside, 0]));
  const ahead = turn(state.rotation, [1, 0, 0]);
  const up = turn(state.rotation, [0, 1, 0]);
  const heading = headingOf(ahead);
  // The plane of the underside as a height over the map: dy = -(up_x dx + up_z dz) / up_y.
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const rise = (dx: number, dz: number) => -(up[0] * dx + up[2] * dz) / Math.max(up[1], 0.2);
  return {
    shape: "box",
    x,
    y,
    z,
    heading,
    length: BODY.length * Math.hypot(ahead[0], ahead[2]),
    width: BODY.width * Math.max(up[1], 0.2),
    slopeAlong: rise(c, s),
    slopeAcross: rise(-s, c),
    ...(from && { from }),
  };
}

/** Whether the car stands on its wheels rather than on its side or roof. */
export function upright(state: CarState): boolean {
  return turn(state.rotation, [0, 1, 0])[1] > 0.3;
}
