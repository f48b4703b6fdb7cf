import { describe, expect, it } from "vitest";
import type { CarPose } from "../../src/render/car/car_pose";
import { LUMP, LumpMotion, MOST_LUMPS } from "../../src/render/car/lump_motion";
import { MOST, SprayMotion } from "../../src/render/car/spray_motion";

/** A source of numbers that is the same in every test (Lehmer 1951, modulus 2^31 - 1, factor 48271). */
const dice = () => {
  let state = 4711;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
};

/** One wheel at x that moves along x at a speed [m/s]. */
const car = (x: number, speed: number, sinkage: number): CarPose => ({
  position: [x, 0.6, 0],
  rotation: [0, 0, 0, 1],
  velocity: [speed, 0, 0],
  wheels: [{ centre: [x, 0.38, 0], steer: 0, spin: 0, radius: 0.38, width: 0.26, slip: 0, sinkage, grounded: true }], // prettier-ignore
});

describe("lumps", () => {
  it("break off the rims of a deep rut, as many a metre at any speed and frame rate, none off a shallow one", () => {
    const counts = [[5, 60], [20, 60], [5, 20]].map(([speed, rate]) => {
      const motion = new LumpMotion(() => 0.4, dice());
      for (let n = 0; n < (20 * rate!) / speed!; n++) motion.step(1 / rate!, car((n * speed!) / rate!, speed!, 0.3));
      return motion.count;
    }); // prettier-ignore
    // 11 a metre over 20 m; one may be owed, one frame's way is cut off.
    for (const count of counts) expect(Math.abs(count - 220)).toBeLessThan(8);
    const shallow = new LumpMotion(() => 0.4, dice());
    for (let n = 0; n < 200; n++) shallow.step(1 / 60, car(n / 6, 10, 0.04));
    expect(shallow.count).toBe(0);
  });

  it("lie on the snow beside the rut, behind the wheel", () => {
    const motion = new LumpMotion((x) => 0.4 + 0.01 * x, dice());
    for (let n = 0; n < 120; n++) motion.step(1 / 60, car(n / 6, 10, 0.3));
    for (let k = 0; k < motion.count; k++) {
      const [x, y, z, size] = motion.lumps.subarray(k * LUMP, k * LUMP + LUMP);
      expect(Math.abs(z!)).toBeGreaterThan(0.13);
      expect(Math.abs(z!)).toBeLessThan(0.5);
      expect(Math.abs(y! - (0.4 + 0.01 * x!))).toBeLessThan(size!);
      expect(x!).toBeLessThan(20);
    }
  });

  it("are crushed by the next wheel, and make room for new ones", () => {
    const motion = new LumpMotion(() => 0, dice());
    motion.land(3, 0, 0.05);
    motion.land(9, 0, 0.05);
    motion.step(1 / 60, car(3, 1, 0));
    expect([motion.lumps[3], motion.lumps[LUMP + 3]]).toEqual([0, Math.fround(0.05)]);
    for (let k = 0; k < MOST_LUMPS + 5; k++) motion.land(50 + k, 0, 0.05);
    expect(motion.count).toBe(MOST_LUMPS);
  });

  it("are what thrown clods become where they come down", () => {
    const landed: number[] = [];
    const spray = new SprayMotion(
      () => 0.1,
      dice(),
      (_, __, size) => landed.push(size),
    );
    for (let n = 0; n < 240; n++) spray.step(1 / 60, { ...car(n / 6, 10, 0.3) });
    expect(spray.count).toBeLessThanOrEqual(MOST);
    expect(landed.length).toBeGreaterThan(20);
    for (const size of landed) expect(size).toBeLessThan(0.07);
  });
});
