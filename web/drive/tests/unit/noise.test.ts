import { describe, expect, it } from "vitest";
import { hash, mix, noise, noiseWithSlope, random, ridges, smoothstep } from "../../src/world/noise";

const places = Array.from(
  { length: 400 },
  (_, k) => [80 * random(k, 1, 5) - 40, 80 * random(k, 2, 5) - 40] as const,
);

describe("noise", () => {
  it("is zero at whole numbers, where only one corner counts and the distance to it is zero", () => {
    for (let i = -3; i < 4; i++) expect(noise(i, 2 * i + 1, 9)).toBe(0);
  });

  it("stays within -1..1 and uses most of it", () => {
    const values = places.map(([x, z]) => noise(x, z, 3));
    expect(Math.max(...values.map(Math.abs))).toBeLessThanOrEqual(1);
    expect(Math.max(...values)).toBeGreaterThan(0.5);
    expect(Math.min(...values)).toBeLessThan(-0.5);
  });

  it("has the gradient of its own differences", () => {
    const e = 1e-4;
    for (const [x, z] of places) {
      const { dx, dz } = noiseWithSlope(x, z, 3, { value: 0, dx: 0, dz: 0 });
      // Central differences err by e^2 f'''/6; the third derivative of the quintic blend is below 500.
      const bound = (e * e * 500) / 6 + 1e-10;
      expect(Math.abs((noise(x + e, z, 3) - noise(x - e, z, 3)) / (2 * e) - dx)).toBeLessThan(bound);
      expect(Math.abs((noise(x, z + e, 3) - noise(x, z - e, 3)) / (2 * e) - dz)).toBeLessThan(bound);
    }
  });

  it("differs from seed to seed and is the same for the same seed", () => {
    expect(noise(0.3, 0.4, 1)).toBe(noise(0.3, 0.4, 1));
    expect(noise(0.3, 0.4, 1)).not.toBe(noise(0.3, 0.4, 2));
  });

  it("has even shares of random numbers", () => {
    const bins = new Array<number>(16).fill(0);
    for (let i = -50; i < 50; i++) for (let j = -50; j < 50; j++) bins[hash(i, j, 7) >>> 28]!++;
    // 10 000 numbers in 16 bins: 625 each, standard deviation 24; five of them are allowed.
    for (const count of bins) expect(Math.abs(count - 625)).toBeLessThan(121);
  });

  it("has ridges between 0 and 1", () => {
    const values = places.map(([x, z]) => ridges(x, z, 3, 5));
    expect(Math.min(...values)).toBeGreaterThanOrEqual(0);
    expect(Math.max(...values)).toBeLessThanOrEqual(1);
  });

  it("steps and mixes", () => {
    expect([smoothstep(2, 4, 1), smoothstep(2, 4, 3), smoothstep(2, 4, 9), smoothstep(4, 2, 1)]).toEqual([
      0, 0.5, 1, 1,
    ]);
    expect(mix(2, 4, 0.25)).toBe(2.5);
  });
});
