import { describe, expect, it } from "vitest";
import { haloStrengths } from "../../src/render/car/lamps";
import { daylight } from "../../src/render/sky/daylight";

describe("haloStrengths", () => {
  it("are none by day, whatever shines", () => {
    for (const hour of [9, 12, 15])
      for (const [need, braking] of [
        [0, 1],
        [1, 0],
        [1, 1],
      ] as const)
        expect(haloStrengths(need, braking, daylight(hour).lamps)).toEqual([0, 0]);
  });

  it("are those of the lamps at night, brakes brighter than tail lamps", () => {
    const { lamps } = daylight(0);
    expect(haloStrengths(1, 0, lamps)).toEqual([1, 0.45]);
    expect(haloStrengths(1, 1, lamps)).toEqual([1, 1]);
    expect(haloStrengths(0, 1, lamps)).toEqual([0, 1]); // lights switched off by hand
  });
});
