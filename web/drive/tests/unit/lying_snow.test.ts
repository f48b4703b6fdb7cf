import { describe, expect, it } from "vitest";
import { carAt } from "../../src/course/run";
import { snowedAfter } from "../../src/render/car/lying_snow";

const drive = { time: 1, rows: [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0] };

/** A car at a speed [m/s] in ruts of a depth [m]. */
function car(speed: number, sinkage: number) {
  const pose = carAt(drive, 0.5, 0.38, 0.26);
  const wheels = pose.wheels.map((wheel) => ({ ...wheel, sinkage, grounded: true }));
  return { ...pose, velocity: [speed, 0, 0] as const, wheels };
}

describe("snow on the car", () => {
  it("gathers in a minute in which it digs through deep snow", () => {
    expect(snowedAfter(0.25, 60, car(8, 0.2))).toBeGreaterThan(0.9);
    expect(snowedAfter(1, 600, car(8, 0.2))).toBeLessThan(1);
  });

  it("blows off slowly on bare ground, but for what is in the corners", () => {
    const soon = snowedAfter(1, 60, car(20, 0));
    expect(soon).toBeGreaterThan(0.8);
    expect(soon).toBeLessThan(0.9);
    expect(snowedAfter(1, 3600, car(20, 0))).toBeCloseTo(0.25, 3);
  });

  it("does not gather on a car that stands, however deep", () => {
    expect(snowedAfter(0.25, 60, car(0, 0.3))).toBeCloseTo(0.25, 12);
  });

  it("is the same in however many frames the time passes", () => {
    for (const frames of [1, 30, 600]) {
      let snowed = 0.3;
      for (let n = 0; n < frames; n++) snowed = snowedAfter(snowed, 10 / frames, car(5, 0.1));
      expect(snowed).toBeCloseTo(snowedAfter(0.3, 10, car(5, 0.1)), 12);
    }
  });
});
