/** Where the picture is taken from. Pure: the state of the car, time and input go in, a view comes out. */
import type { PerspectiveCamera } from "three";
import { add, scale, turn, type Vec } from "../geometry";
import type { CarState } from "../state";

export const CAMERAS = ["chase", "cockpit", "free", "top"] as const;
export type CameraName = (typeof CAMERAS)[number];

export interface View {
  position: Vec;
  target: Vec;
  /** Vertical field of view [degrees]. */
  fov: number;
}

/** What mouse and keys ask of the camera: turns [rad] and zoom since the last time, and directions to fly, -1..1. */
export interface CameraInput {
  readonly turn: number;
  readonly tilt: number;
  readonly zoom: number;
  readonly ahead: number;
  readonly right: number;
  readonly up: number;
}

export const STILL: CameraInput = { turn: 0, tilt: 0, zoom: 0, ahead: 0, right: 0, up: 0 };

/** Height of what can be seen from above: the surface of the snow [m]. */
export type Surface = (x: number, z: number) => number;

/** How far the camera stays above the surface [m]. */
export const ABOVE = 0.7;
/** Rates at which the chasing camera follows heading and height [1/s]. */
const TURNING = 3.2;
const RISING = 6;
/** Speed of flight [m/s]. */
const FLIGHT = 14;
/** Where the driver's eyes are in the chassis frame [m]. */
const EYES: Vec = [-0.35, 0.68, -0.36];

export class Cameras {
  name: CameraName = "chase";
  private readonly surface: Surface;
  /** Direction in which the chasing camera looks [rad]; null until the first view. */
  private heading: number | null = null;
  private height: number | null = null;
  /** The visitor's own part: angles and distance about the car, and how far the middle has flown from it. */
  private orbit = { turn: 0, tilt: 0.35, distance: 8 };
  private away: Vec = [0, 0, 0];
  private zoom = 1;
  /** Vertical field of view of the free camera [degrees]. */
  private lens = 50;

  constructor(surface: Surface) {
    this.surface = surface;
  }

  /** Take the next camera. */
  next(): CameraName {
    return this.choose(CAMERAS[(CAMERAS.indexOf(this.name) + 1) % CAMERAS.length]!);
  }

  choose(name: CameraName): CameraName {
    this.name = name;
    this.away = [0, 0, 0];
    this.zoom = 1;
    return name;
  }

  /** The view after dt [s]. */
  update(state: CarState, dt: number, input: CameraInput = STILL): View {
    const ahead = turn(state.rotation, [1, 0, 0]);
    this.zoom = within(0.4, 4, this.zoom * Math.exp(input.zoom));
    // The chasing heading goes on in every camera, so that coming back to it makes no sweep.
    this.followHeading(state, Math.atan2(ahead[2], ahead[0]), dt);
    switch (this.name) {
      case "chase":
        return this.chase(state, input, dt);
      case "cockpit":
        return this.cockpit(state);
      case "free":
        return this.free(state, input, dt);
      case "top":
        return this.top(state);
    }
  }

  /** Let the free camera see a narrower (factor below 1) or wider part. */
  widen(factor: number): void {
    this.lens = within(8, 90, this.lens * factor);
  }

  private followHeading(state: CarState, heading: number, dt: number): void {
    const [vx, , vz] = state.velocity;
    const pace = Math.hypot(vx, vz);
    // In a slide the way of travel counts as well as the nose; backwards and at rest only the nose.
    const slide = state.speed > 2 ? Math.min(0.5, pace / 20) : 0;
    const aim = heading + slide * wrap(Math.atan2(vz, vx) - heading);
    const now = this.heading ?? aim;
    this.heading = now + wrap(aim - now) * -Math.expm1(-TURNING * dt);
  }

  private chase(state: CarState, input: CameraInput, dt: number): View {
    this.orbit.turn = wrap(this.orbit.turn + input.turn) * (input.turn === 0 ? Math.exp(-dt) : 1);
    const heading = this.heading! + this.orbit.turn;
    const pace = Math.min(1, Math.abs(state.speed) / 30);
    const distance = (5.6 + 1.8 * pace) * this.zoom;
    const [x, y, z] = state.position;
    // The first view, or the car was put elsewhere: no sweep.
    const before = this.height === null || Math.abs(this.height - y) > 5 ? y : this.height;
    this.height = before + (y - before) * -Math.expm1(-RISING * dt);
    const back: Vec = [
      -Math.cos(heading) * distance,
      1.75 * this.zoom + 0.2 * pace,
      -Math.sin(heading) * distance,
    ];
    const position = this.over(add([x, this.height, z], back));
    const target: Vec = [x + 1.5 * Math.cos(heading), y + 0.65, z + 1.5 * Math.sin(heading)];
    return { position, target, fov: 52 + 12 * pace };
  }

  private cockpit(state: CarState): View {
    const position = add(state.position, turn(state.rotation, EYES));
    return { position, target: add(position, turn(state.rotation, [10, -0.5, 0])), fov: 68 };
  }

  private free(state: CarState, input: CameraInput, dt: number): View {
    const { orbit } = this;
    orbit.turn = wrap(orbit.turn + input.turn);
    orbit.tilt = within(-0.2, 1.5, orbit.tilt + input.tilt);
    const [c, s] = [Math.cos(orbit.turn), Math.sin(orbit.turn)];
    const fly: Vec = [c * input.ahead - s * input.right, input.up, s * input.ahead + c * input.right];
    this.away = add(this.away, scale(fly, FLIGHT * dt));
    const target = add(add(state.position, [0, 0.4, 0]), this.away);
    const distance = orbit.distance * this.zoom;
    const flat = distance * Math.cos(orbit.tilt);
    const position = this.over(add(target, [-flat * c, distance * Math.sin(orbit.tilt), -flat * s]));
    return { position, target, fov: this.lens };
  }

  private top(state: CarState): View {
    const [x, y, z] = state.position;
    const high = (22 + 0.6 * Math.abs(state.speed)) * this.zoom;
    const [vx, , vz] = state.velocity;
    const target: Vec = [x + 0.4 * vx, y, z + 0.4 * vz];
    // A little to the south, so that "up" in the picture is north and never undefined.
    return { position: this.over([target[0], y + high, target[2] + 0.12 * high]), target, fov: 50 };
  }

  /** A place lifted over the surface about it. */
  private over([x, y, z]: Vec): Vec {
    let least = this.surface(x, z);
    for (const [dx, dz] of [
      [0.8, 0],
      [-0.8, 0],
      [0, 0.8],
      [0, -0.8],
    ] as const) {
      // prettier-ignore
      least = Math.max(least, this.surface(x + dx, z + dz));
    }
    return [x, Math.max(y, least + ABOVE), z];
  }
}

/** An angle in -pi..pi. */
function wrap(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

function within(low: number, high: number, x: number): number {
  return Math.min(high, Math.max(low, x));
}

/** Give a view to three's camera. */
export function aim(camera: PerspectiveCamera, view: View): void {
  camera.position.set(...view.position);
  camera.lookAt(...view.target);
  if (camera.fov === view.fov) return;
  camera.fov = view.fov;
  camera.updateProjectionMatrix();
}
