import { describe, expect, it } from "vitest";
import { CLEARING, placesOf, TILE, treeMayStand } from "../../src/world/places";
import { makeTerrain } from "../../src/world/terrain";
import type { Terrain } from "../../src/world/terrain_type";

const terrain = makeTerrain(1);
const tiles = [-2, -1, 0, 1, 2].flatMap((j) => [-2, -1, 0, 1, 2].map((i) => [i, j] as const));

describe("placesOf", () => {
  it("plants the same at every visit", () => {
    for (const [i, j] of tiles.slice(0, 5))
      expect(placesOf(terrain, i, j, 7)).toEqual(placesOf(terrain, i, j, 7));
  });

  it("keeps things on their tile, on the ground, and off the clearing at the start", () => {
    let count = 0;
    for (const [i, j] of tiles) {
      const { trees, rocks, poles } = placesOf(terrain, i, j, 7);
      for (const p of [...trees, ...rocks, ...poles]) {
        count++;
        expect(Math.floor(p.x / TILE)).toBe(i);
        expect(Math.floor(p.z / TILE)).toBe(j);
        // Trees are sunk by 0.1 m so that no slope shows below their stem.
        expect(Math.abs(p.y - terrain.height(p.x, p.z))).toBeLessThan(0.1 + 1e-9);
        expect(Math.hypot(p.x, p.z)).toBeGreaterThanOrEqual(CLEARING);
      }
    }
    expect(count).toBeGreaterThan(100);
  });

  it("leaves roads and ice free of trees", () => {
    for (const [i, j] of tiles) {
      for (const { x, z } of placesOf(terrain, i, j, 7).trees) {
        const [, packed, ice] = terrain.kinds(x, z);
        expect(packed).toBeLessThan(0.55);
        expect(ice).toBeLessThan(0.02);
      }
    }
    const open: Terrain = { height: () => 0, slope: () => [0, 0], cover: () => 1, kinds: () => [1, 0, 0] };
    expect(treeMayStand(open, 30, 30)).toBe(true);
    expect(treeMayStand({ ...open, kinds: () => [0, 1, 0] }, 30, 30)).toBe(false);
    expect(treeMayStand({ ...open, kinds: () => [0, 0, 1] }, 30, 30)).toBe(false);
    expect(treeMayStand({ ...open, slope: () => [0.9, 0] }, 30, 30)).toBe(false);
  });
});
