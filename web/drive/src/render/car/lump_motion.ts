/** Lumps of snow that lie about a track, as numbers: clods that have landed, and crumbs that broke off the rims. */
import type { CarPose } from "./car_pose";

/** Lumps at most; the oldest makes room. */
export const MOST_LUMPS = 600;
/** Numbers of a lump: place (3), size [m], seed 0..1, age [s]. */
export const LUMP = 6;

/** Crumbs that a metre of a deep rut breaks off its two rims. */
const CRUMBS = 11;
/** Sinkage from which on rims break [m]. */
const DEEP = 0.05;
/** How far a lump sinks into what it lies on, in sizes. */
const BEDDED = 0.3;

export type Height = (x: number, z: number) => number;

export class LumpMotion {
  /** Lumps one after the other, `count` of them, as `LUMP` numbers each; size 0: gone. */
  readonly lumps = new Float32Array(MOST_LUMPS * LUMP);
  count = 0;
  /** Whether a lump came or went since this was last set to false. */
  changed = false;
  private next = 0;
  private readonly owed: number[] = [];
  private readonly surface: Height;
  private readonly random: () => number;

  /** `surface`: height of the snow [m]; `random`: numbers in [0, 1). */
  constructor(surface: Height, random: () => number = Math.random) {
    this.surface = surface;
    this.random = random;
  }

  /** Go on by dt [s]: rims crumble beside wheels that roll deep, wheels crush what lies in their way. */
  step(dt: number, car: CarPose): void {
    const speed = Math.hypot(...car.velocity);
    for (let k = 0; k < this.count; k++) this.lumps[k * LUMP + 5]! += dt;
    car.wheels.forEach((wheel, k) => {
      const [x, , z] = wheel.centre;
      this.crush(x, z, wheel.radius);
      const deep = wheel.grounded ? Math.min(1, Math.max(0, wheel.sinkage - DEEP) / 0.1) : 0;
      let owed = (this.owed[k] ?? 0) + deep * CRUMBS * speed * dt;
      for (; owed >= 1; owed--) this.crumble(wheel, car.velocity, speed);
      this.owed[k] = owed;
    });
  }

  /** A clod of a size [m] has come to rest at (x, z). */
  land(x: number, z: number, size: number): void {
    const k = this.next;
    this.next = (k + 1) % MOST_LUMPS;
    this.count = Math.max(this.count, k + 1);
    const y = this.surface(x, z) + (0.5 - BEDDED) * size;
    this.lumps.set([x, y, z, size, this.random(), 0], k * LUMP);
    this.changed = true;
  }

  private crumble(wheel: CarPose["wheels"][number], velocity: CarPose["velocity"], speed: number): void {
    const { random } = this;
    const [dx, dz] = [velocity[0] / speed, velocity[2] / speed];
    const side = random() < 0.5 ? -1 : 1;
    // Behind the wheel, where it no longer crushes them; most lie close to the rut.
    const back = wheel.radius * (1.1 + 0.5 * random());
    const out = side * (0.5 * wheel.width + 0.03 + 0.32 * random() ** 2);
    const [x, , z] = wheel.centre;
    this.land(x - back * dx - out * dz, z - back * dz + out * dx, 0.02 + 0.075 * random() ** 3);
  }

  private crush(x: number, z: number, reach: number): void {
    for (let k = 0; k < this.count; k++) {
      const at = k * LUMP;
      if (this.lumps[at + 3] === 0) continue;
      if (Math.hypot(this.lumps[at]! - x, this.lumps[at + 2]! - z) > 0.6 * reach) continue;
      this.lumps[at + 3] = 0;
      this.changed = true;
    }
  }
}
