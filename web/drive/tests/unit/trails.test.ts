import { describe, expect, it } from "vitest";
import { Trails } from "../../src/others/trails";
import { underside } from "../../src/snow/prints";
import { STAMPS } from "../../src/snow/footprint";
import { TILE } from "../../src/world/places";
import { makeTerrain } from "../../src/world/terrain";
import { LEVEL } from "../../src/world/terrain_type";
import { trailsOf } from "../../src/world/trails";
import { ICE, plain, POWDER } from "./car_world";

const all = (terrain = LEVEL) =>
  [-1, 0, 1].flatMap((i) => [-1, 0, 1].flatMap((j) => trailsOf(terrain, i, j, 7)));

describe("trails", () => {
  it("are the same at every visit, in step, and on powder alone", () => {
    const [once, again] = [all(), all()];
    expect(once.length).toBeGreaterThan(200);
    expect(again.map(({ x, z }) => [x, z])).toEqual(once.map(({ x, z }) => [x, z]));
    expect(all(plain(ICE))).toEqual([]);
    const map = makeTerrain(7);
    for (const { x, z } of all(map)) expect(map.kinds(x, z)[0]).toBeGreaterThan(0.5);
  });

  it("are in sight where the car begins: steps within ten metres of it", () => {
    const near = all(makeTerrain(7)).filter(({ x, z }) => Math.hypot(x, z) < 10);
    expect(near.length).toBeGreaterThan(3);
  });

  it("press into the snow, not through it, and nowhere above it", () => {
    for (const step of all(plain(POWDER)))
      for (const stamp of step.stamps(3, 0.4)) {
        const bottom = underside(stamp, stamp.x, stamp.z);
        expect(bottom).toBeLessThan(3.4 - 0.05);
        expect(bottom).toBeGreaterThan(3.1);
      }
  });

  it("are pressed once each, the nearest first, a set of passes at a time, where the window is", () => {
    const trails = new Trails(LEVEL, (i, j) => trailsOf(LEVEL, i, j, 7));
    const seen: { x: number; z: number }[] = [];
    for (let n = 0; n < 2000; n++) {
      const stamps = trails.due(1 / 60, 10, 20, 25, 0.4);
      expect(stamps.length).toBeLessThanOrEqual(STAMPS);
      seen.push(...stamps);
    }
    // Feet lie within a step of the place that counts.
    for (const { x, z } of seen) expect(Math.max(Math.abs(x - 10), Math.abs(z - 20))).toBeLessThan(25.5);
    expect(new Set(seen.map(({ x, z }) => `${x} ${z}`)).size).toBe(seen.length);
    const steps = all().filter(({ x, z }) => Math.max(Math.abs(x - 10), Math.abs(z - 20)) <= 25);
    expect(seen).toHaveLength(steps.flatMap((step) => step.stamps(0, 0.4)).length);
    const away = ({ x, z }: { x: number; z: number }) => Math.max(Math.abs(x - 10), Math.abs(z - 20));
    expect(away(seen[0]!)).toBeLessThan(away(seen[seen.length - 1]!));
    // Another place brings others; coming back soon brings none again.
    let others = 0;
    for (let n = 0; n < 600; n++) others += trails.due(1 / 60, 10 + TILE, 20, 45, 0.4).length;
    expect(others).toBeGreaterThan(0);
    for (let n = 0; n < 60; n++) expect(trails.due(1 / 60, 10, 20, 25, 0.4)).toEqual([]);
  });
});
