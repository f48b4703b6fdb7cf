import { describe, expect, it } from "vitest";
import type { CarPose, WheelPose } from "../../src/render/car/car_pose";
import { MOST, SprayMotion, STRIDE, throwRate } from "../../src/render/car/spray_motion";

const wheel = (x: number, z: number, sinkage: number): WheelPose => ({
  centre: [x, 0.38, z],
  steer: 0,
  spin: 0,
  radius: 0.38,
  width: 0.26,
  slip: 1,
  sinkage,
  grounded: true,
});
const car = (speed: number, sinkage: number): CarPose => ({
  position: [0, 0.6, 0],
  rotation: [0, 0, 0, 1],
  velocity: [speed, 0, 0],
  wheels: [
    wheel(1.3, -0.8, sinkage),
    wheel(1.3, 0.8, sinkage),
    wheel(-1.3, -0.8, sinkage),
    wheel(-1.3, 0.8, sinkage),
  ],
});

/** A source of numbers that is the same in every test (Lehmer 1951, modulus 2^31 - 1, factor 48271). */
const dice = () => {
  let state = 12345;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
};

describe("SprayMotion", () => {
  it("throws nothing at rest, on bare ground or in the air", () => {
    expect(throwRate(0, 0, 0.2)).toBe(0);
    expect(throwRate(15, 8, 0)).toBe(0);
    const motion = new SprayMotion(() => 0, dice());
    const flying = car(12, 0.2);
    motion.step(0.5, { ...flying, wheels: flying.wheels.map((w) => ({ ...w, grounded: false })) });
    expect(motion.count).toBe(0);
  });

  it("throws as many in a second whatever the number of updates", () => {
    const thrown = [20, 60, 144].map((n) => {
      const motion = new SprayMotion(() => -1e9, dice());
      // A tenth of a second, before the first of them is gone.
      for (let k = 0; k < n / 10; k++) motion.step(1 / n, car(6, 0.2));
      return motion.count / (Math.ceil(n / 10) / n);
    });
    // Each of four wheels may owe up to one grain at the end: 4 in 0.1 s.
    expect(Math.abs(thrown[1]! - thrown[0]!)).toBeLessThanOrEqual(40);
    expect(Math.abs(thrown[2]! - thrown[0]!)).toBeLessThanOrEqual(40);
  });

  it("never holds more than it can, keeps numbers finite, and is empty some time after the car has stopped", () => {
    const motion = new SprayMotion(() => 0, dice());
    for (let k = 0; k < 300; k++) motion.step(1 / 60, car(25, 0.4));
    expect(motion.count).toBeLessThanOrEqual(MOST);
    expect(motion.count).toBeGreaterThan(100);
    for (let k = 0; k < motion.count * STRIDE; k++) expect(Number.isFinite(motion.grains[k])).toBe(true);
    // The longest life is 1.65 s.
    for (let k = 0; k < 110; k++) motion.step(1 / 60, car(0, 0.4));
    for (const still of [car(0, 0)])
      for (let k = 0; k < 110; k++) motion.step(1 / 60, { ...still, wheels: [] });
    expect(motion.count).toBe(0);
  });
});
