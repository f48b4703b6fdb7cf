/** Snow thrown by the wheels, as numbers: soft puffs that grow and fade, and clods that fly and fall. */
import type { CarPose, WheelPose } from "./car_pose";

/** Grains at most. */
export const MOST = 1100;
/** Numbers of a grain: place (3), size, opacity, seed, kind (0 puff, 1 clod), age 0..1. */
export const STRIDE = 8;

const GRAVITY = 9.81;

/** Grains that a wheel throws in a second: none on bare ground or at rest. */
export function throwRate(speed: number, slip: number, sinkage: number): number {
  const loose = Math.min(1, Math.max(0, sinkage) / 0.09);
  const stir = Math.max(0, speed - 1.2) * 9 + Math.max(0, Math.abs(slip) - 0.4) * 24;
  return loose * Math.min(190, stir);
}

export class SprayMotion {
  /** Grains one after the other, `count` of them, as `STRIDE` numbers each. */
  readonly grains = new Float32Array(MOST * STRIDE);
  count = 0;
  private readonly speeds = new Float32Array(MOST * 3);
  private readonly lives = new Float32Array(MOST);
  private readonly grown = new Float32Array(MOST);
  private readonly owed: number[] = [];
  private random: () => number;
  private readonly floor: (x: number, z: number) => number;
  private readonly landed: (x: number, z: number, size: number) => void;

  /**
   * `floor`: height on which clods come to rest [m]; `random`: numbers in [0, 1); `landed` hears where a clod comes
   * to rest, with its size [m].
   */
  constructor(
    floor: (x: number, z: number) => number,
    random: () => number = Math.random,
    landed: (x: number, z: number, size: number) => void = () => undefined,
  ) {
    this.landed = landed;
    this.floor = floor;
    this.random = random;
  }

  /** Go on by dt [s]: throw from the wheels, move what flies, forget what is gone. */
  step(dt: number, car: CarPose): void {
    this.fly(dt);
    const speed = Math.hypot(...car.velocity);
    car.wheels.forEach((wheel, k) => {
      const rate = wheel.grounded ? throwRate(speed, wheel.slip, wheel.sinkage) : 0;
      let owed = (this.owed[k] ?? 0) + rate * dt;
      for (; owed >= 1; owed--) this.add(wheel, car, speed);
      this.owed[k] = owed;
    });
  }

  private fly(dt: number): void {
    const { grains, speeds, lives } = this;
    for (let k = this.count - 1; k >= 0; k--) {
      const g = k * STRIDE;
      const age = grains[g + 7]! + dt / lives[k]!;
      const clod = grains[g + 6] === 1;
      // Puffs are light: the air stops them soon and they sink slowly. Clods hardly feel it.
      const drag = Math.exp(-dt * (clod ? 0.25 : 2.6));
      for (let a = 0; a < 3; a++) {
        let v = speeds[3 * k + a]! * drag;
        if (a === 1) v -= dt * (clod ? GRAVITY : 0.9);
        speeds[3 * k + a] = v;
        grains[g + a] = grains[g + a]! + v * dt;
      }
      const down = clod && speeds[3 * k + 1]! < 0 && grains[g + 1]! < this.floor(grains[g]!, grains[g + 2]!);
      if (down) this.landed(grains[g]!, grains[g + 2]!, grains[g + 3]!);
      if (age >= 1 || down) {
        this.forget(k);
        continue;
      }
      grains[g + 7] = age;
      if (clod) continue;
      grains[g + 3] = this.grown[k]! * (0.25 + 0.75 * Math.sqrt(age));
      grains[g + 4] = 0.42 * Math.min(1, age * 9) * (1 - age) ** 1.5;
    }
  }

  private forget(k: number): void {
    const last = --this.count;
    this.grains.copyWithin(k * STRIDE, last * STRIDE, (last + 1) * STRIDE);
    this.speeds.copyWithin(3 * k, 3 * last, 3 * last + 3);
    this.lives[k] = this.lives[last]!;
    this.grown[k] = this.grown[last]!;
  }

  private add(wheel: WheelPose, car: CarPose, speed: number): void {
    if (this.count >= MOST) return;
    const { random } = this;
    const k = this.count++;
    const [vx, , vz] = car.velocity;
    const [dx, dz] = speed > 0.5 ? [vx / speed, vz / speed] : this.heading(car);
    const side = random() < 0.5 ? -1 : 1;
    const clod = random() < 0.4;
    const eager = Math.min(1.6, 0.25 + speed / 14 + Math.abs(wheel.slip) / 9);
    const [cx, cy, cz] = wheel.centre;
    const back = wheel.radius * (0.5 + 0.5 * random());
    const out = side * wheel.width * (0.4 + 0.3 * random());
    this.grains.set(
      [cx - back * dx - out * dz, cy - wheel.radius * (0.55 + 0.35 * random()), cz - back * dz + out * dx],
      k * STRIDE,
    );
    const aside = side * (0.3 + 1.6 * random()) * eager;
    const follow = clod ? 0.55 + 0.2 * random() : 0.3 + 0.25 * random();
    const thrown = Math.max(0, wheel.slip) * (0.25 + 0.35 * random());
    const rise = (clod ? 1.2 + 3.2 * random() : 0.5 + 1.7 * random()) * eager;
    this.speeds.set(
      [vx * follow - dx * thrown - dz * aside, rise, vz * follow - dz * thrown + dx * aside],
      3 * k,
    );
    this.lives[k] = clod ? 1.6 : 0.55 + 1.1 * random();
    this.grown[k] = (0.35 + 0.85 * random()) * (0.55 + 0.5 * eager);
    this.grains.set(
      [clod ? 0.018 + 0.045 * random() ** 2 : 0.1, clod ? 1 : 0, random(), clod ? 1 : 0, 0],
      k * STRIDE + 3,
    );
  }

  private heading(car: CarPose): [number, number] {
    const [front, rear] = [car.wheels[0]!.centre, car.wheels[car.wheels.length - 1]!.centre];
    const [x, z] = [front[0] - rear[0], front[2] - rear[2]];
    const length = Math.hypot(x, z) || 1;
    return [x / length, z / length];
  }
}
