import { readFile } from "node:fs/promises";
import { afterEach, describe, expect, it, vi } from "vitest";
import { fetchGround, readGround, type Snowed } from "../../src/bridge/ground";
import { outside, usualDepth } from "../../src/world/snowed_land";
import { placesOf, TILE } from "../../src/world/places";
import { makeTerrain, SPACING } from "../../src/world/terrain";

const FILE = new URL("../../public/grounds/snowed_slope.json", import.meta.url);
const text = await readFile(FILE, "utf8");

/** A piece of 40 m x 24 m whose ground and snow are planes: height and depth at x east, y north of its middle [m]. */
const HEIGHT = (x: number, y: number) => 5 + 0.1 * x - 0.05 * y;
const DEPTH = (x: number, y: number) => 0.3 + 0.002 * x + 0.001 * y;
function piece(depth = DEPTH): Snowed {
  const [nx, ny, cell] = [80, 48, 0.5];
  const fill = (of: (x: number, y: number) => number) =>
    Float32Array.from({ length: nx * ny }, (_, k) =>
      of((Math.floor(k / ny) + 0.5 - nx / 2) * cell, ((k % ny) + 0.5 - ny / 2) * cell),
    );
  return { name: "plane", nx, ny, cell, ground: fill(HEIGHT), depth: fill(depth) };
}
const ON_IT = [
  [0, 0],
  [-19, 11],
  [7.5, -3],
  [19, 8.5],
] as const; // x, z on the lattice
const usual = usualDepth(piece());

describe("a snowed piece of ground", () => {
  it("is the ground of the start, north up, at the height of the hills there", () => {
    const [land, hills] = [makeTerrain(7, piece()), makeTerrain(7)];
    for (const [x, z] of ON_IT) {
      const wanted = HEIGHT(x, -z) - HEIGHT(0, 0) + hills.height(0, 0);
      expect(land.height(x, z)).toBeCloseTo(wanted, 5); // float32 of 10 m: 1e-6
      const [sx, sz] = land.slope(x + 0.1, z + 0.1);
      expect(sx).toBeCloseTo(0.1, 4);
      expect(sz).toBeCloseTo(0.05, 4);
    }
  });

  it("has the snow of the fall, of powder alone", () => {
    const land = makeTerrain(7, piece());
    for (const [x, z] of ON_IT) {
      expect(usual * land.cover(x, z)).toBeCloseTo(DEPTH(x, -z), 6);
      expect(land.kinds(x, z)).toEqual([1, 0, 0]);
    }
  });

  it("ends in a seam beyond which the hills are as they were", () => {
    const [land, hills] = [makeTerrain(7, piece()), makeTerrain(7)];
    for (const [x, z] of [
      [45, 0],
      [-60, 70],
      [3, -37],
    ] as const) {
      expect(outside(piece(), x, z)).toBeGreaterThan(24);
      expect(land.height(x, z)).toBe(hills.height(x, z));
      expect(land.cover(x, z)).toBe(hills.cover(x, z));
      expect(land.kinds(x, z)).toEqual(hills.kinds(x, z));
    }
    // No step at the rim: between neighbours of the lattice no more than slopes of both and the seam's give.
    for (let x = 0; x < 50; x += SPACING)
      expect(Math.abs(land.height(x + SPACING, 3) - land.height(x, 3))).toBeLessThan(1);
  });

  it("has no trees, rocks or poles", () => {
    const land = makeTerrain(7, piece());
    const free = (x: number, z: number) => outside(piece(), x, z) > 0;
    let found = 0;
    for (const i of [-1, 0])
      for (const j of [-1, 0]) {
        const { trees, rocks } = placesOf(land, i, j, 7, free);
        for (const { x, z } of [...trees, ...rocks]) expect(outside(piece(), x, z)).toBeGreaterThan(0);
        found += trees.length;
      }
    expect(found).toBeGreaterThan(0);
    expect(TILE).toBeGreaterThan(40);
  });

  it.each([
    [() => 0.3, 0.3],
    [() => 0, 0.05],
    [() => 5, 1.2],
    [(x: number) => (x > 19 ? 1.6 : 0.1), 0.8], // the deepest is twice as deep: more is not drawn
  ])("gives the settings the depth of its snow (%#)", (depth, wanted) => {
    expect(usualDepth(piece(depth))).toBeCloseTo(wanted, 9);
  });
});

describe("the file", () => {
  afterEach(() => vi.unstubAllGlobals());

  it("that comes with the page holds a valley under snow", async () => {
    const { name, nx, ny, cell, ground, depth } = await readGround(text);
    expect([name, nx, ny, cell]).toEqual(["snowed_slope", 168, 108, 0.5]);
    expect(ground.length).toBe(nx * ny);
    expect(Math.max(...ground)).toBeGreaterThan(4);
    const mean = depth.reduce((sum, one) => sum + one, 0) / depth.length;
    expect(mean).toBeGreaterThan(0.2);
    expect(mean).toBeLessThan(0.5);
  });

  it.each([
    ["[]", "format undefined"],
    [text.slice(0, -9), "JSON"],
    [text.replace('"nx":168', '"nx":167'), "lengths differ"],
    [text.replace('"cell":0.5', '"cell":0'), "a length is not above 0"],
  ])("is refused in a sentence when it is damaged (%#)", async (damaged, why) => {
    const told = /^The snowed ground is damaged or of another version of Neve \((.*)\)\.$/s;
    await expect(readGround(damaged)).rejects.toThrow(told);
    await expect(readGround(damaged)).rejects.toThrow(why);
  });

  it("that is not there is told in a sentence", async () => {
    let address = "";
    vi.stubGlobal("fetch", (at: string) => ((address = at), Promise.resolve({ ok: false })));
    await expect(fetchGround("a & b")).rejects.toThrow(
      "There is no ground a & b; neve drive --snow FOLDER makes",
    );
    expect(address).toBe("grounds/a%20%26%20b.json");
  });
});
