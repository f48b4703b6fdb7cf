import { describe, expect, it } from "vitest";
import { random } from "../../src/world/noise";
import { makeTerrain, SPACING } from "../../src/world/terrain";

const SEEDS = [1, 2, 3];
const lands = SEEDS.map((seed) => makeTerrain(seed));
const places = Array.from(
  { length: 300 },
  (_, k) => [4000 * random(k, 1, 8) - 2000, 4000 * random(k, 2, 8) - 2000] as const,
);

describe("terrain", () => {
  it("is the same for the same seed, whatever was asked before", () => {
    const again = makeTerrain(1);
    for (const [x, z] of [...places].reverse()) expect(again.height(x, z)).toBe(lands[0]!.height(x, z));
    expect(lands[1]!.height(10, 10)).not.toBe(lands[0]!.height(10, 10));
  });

  it("is bilinear between the points of its lattice", () => {
    const land = lands[0]!;
    for (const [x, z] of places) {
      const [i, j] = [Math.floor(x / SPACING), Math.floor(z / SPACING)];
      const [u, v] = [x / SPACING - i, z / SPACING - j];
      const expected =
        land.lattice(i, j) * (1 - u) * (1 - v) +
        land.lattice(i + 1, j) * u * (1 - v) +
        land.lattice(i, j + 1) * (1 - u) * v +
        land.lattice(i + 1, j + 1) * u * v;
      // Doubles of up to 300 m: a few times 300 * 2^-52.
      expect(Math.abs(land.height(x, z) - expected)).toBeLessThan(1e-12);
      expect(Math.fround(land.lattice(i, j))).toBe(land.lattice(i, j));
      expect(land.height(i * SPACING, j * SPACING)).toBe(land.lattice(i, j));
    }
  });

  it("has slopes that are its differences", () => {
    const e = 1e-3;
    for (const [x0, z0] of places) {
      // Inside a cell the surface is linear in x and in z, so that differences are exact up to rounding:
      // 300 m * 2^-52 / e is below 1e-9.
      const x = (Math.floor(x0 / SPACING) + 0.3) * SPACING;
      const z = (Math.floor(z0 / SPACING) + 0.6) * SPACING;
      const [sx, sz] = lands[0]!.slope(x, z);
      expect(Math.abs((lands[0]!.height(x + e, z) - lands[0]!.height(x - e, z)) / (2 * e) - sx)).toBeLessThan(
        1e-9,
      );
      expect(Math.abs((lands[0]!.height(x, z + e) - lands[0]!.height(x, z - e)) / (2 * e) - sz)).toBeLessThan(
        1e-9,
      );
    }
  });

  it("has types that sum to one and cover between bare and drifted", () => {
    for (const land of lands) {
      for (const [x, z] of places) {
        const kinds = land.kinds(x, z);
        // The lattice keeps float32: each share is known to 2^-24.
        expect(Math.abs(kinds[0] + kinds[1] + kinds[2] - 1)).toBeLessThan(2 ** -22);
        for (const share of kinds) expect(share).toBeGreaterThanOrEqual(0);
        expect(land.cover(x, z)).toBeGreaterThanOrEqual(0);
        expect(land.cover(x, z)).toBeLessThanOrEqual(1.5);
      }
    }
  });

  it("begins on a gentle, open place of powder", () => {
    for (const land of lands) {
      for (let r = 0; r <= 12; r += 2) {
        for (let a = 0; a < 6.28; a += 0.5) {
          const slope = Math.hypot(...land.slope(r * Math.cos(a), r * Math.sin(a)));
          expect(slope).toBeLessThan(0.2); // 11 degrees: any car drives off, none slides
        }
      }
      expect(land.kinds(0, 0)[0]).toBeGreaterThan(0.5);
      expect(land.cover(0, 0)).toBeGreaterThan(0.6);
    }
  });

  it("has a road, a lake that is level, bare rock and mountains within reach", () => {
    for (const land of lands) {
      const found = { road: 0, ice: 0, bare: 0, high: 0 };
      for (let x = -900; x <= 900; x += 12.3) {
        for (let z = -900; z <= 900; z += 12.3) {
          const packed = land.kinds(x, z)[1];
          if (packed > 0.99) found.road++;
          if (land.cover(x, z) === 0) found.bare++;
          if (land.height(x, z) > 40) found.high++;
          // The cell of the lattice is level where all four corners are ice to the full.
          const [i, j] = [Math.floor(x / SPACING), Math.floor(z / SPACING)];
          const corners = [0, 1, 2, 3].map((k) =>
            land.kinds((i + (k & 1)) * SPACING, (j + (k >> 1)) * SPACING),
          );
          if (corners.some((kinds) => kinds[2] < 1)) continue;
          found.ice++;
          expect(Math.hypot(...land.slope(x, z))).toBe(0);
        }
      }
      for (const count of Object.values(found)) expect(count).toBeGreaterThan(20);
    }
  }, 100_000);

  it("is smooth and finite four kilometres away", () => {
    for (const land of lands) {
      for (let k = 0; k < 400; k++) {
        const [x, z] = [4000 + 0.37 * k, -4000 + 0.21 * k];
        const step = land.height(x + 0.37, z + 0.21) - land.height(x, z);
        expect(Number.isFinite(step)).toBe(true);
        expect(Math.abs(step)).toBeLessThan(2.5); // no wall steeper than 80 degrees
      }
    }
  });
});
