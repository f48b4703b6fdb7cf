import { describe, expect, it } from "vitest";
import { DataUtils } from "three";
import { CLIP_SIZE, ClipLevel, KIND_SIZE, uncovered } from "../../src/render/ground/clip_level";
import type { Terrain } from "../../src/world/terrain_type";

const PLANE: Terrain = {
  height: (x, z) => 3 + 0.25 * x - 0.5 * z,
  slope: () => [0.25, -0.5],
  cover: (x) => (x < 0 ? 0 : 1),
  kinds: () => [0.5, 0.25, 0.25],
};

const makeLevel = (terrain: Terrain, spacing: number) => {
  const data = {
    heights: new Float32Array(CLIP_SIZE ** 2),
    slopes: new Uint16Array(2 * CLIP_SIZE ** 2),
    kinds: new Uint8Array(4 * KIND_SIZE ** 2),
  };
  return { level: new ClipLevel(terrain, spacing, data), data };
};

describe("uncovered", () => {
  it("names each point that came into sight once, and no other", () => {
    for (const [di, dj] of [
      [3, 0],
      [-3, 2],
      [5, -4],
      [0, -1],
      [20, 1],
    ] as const) {
      const size = 16;
      const counts = new Map<string, number>();
      for (const [i0, i1, j0, j1] of uncovered(size, [10, -7], 10 + di, -7 + dj)) {
        for (let j = j0; j < j1; j++)
          for (let i = i0; i < i1; i++) counts.set(`${i},${j}`, (counts.get(`${i},${j}`) ?? 0) + 1);
      }
      for (let j = -7 + dj; j < 9 + dj; j++) {
        for (let i = 10 + di; i < 26 + di; i++) {
          const old = i >= 10 && i < 26 && j >= -7 && j < 9;
          expect(counts.get(`${i},${j}`) ?? 0).toBe(old ? 0 : 1);
          counts.delete(`${i},${j}`);
        }
      }
      expect(counts.size).toBe(0);
    }
  });
});

describe("ClipLevel", () => {
  it("holds the same after many moves as one that was made at the end", () => {
    const waves: Terrain = { ...PLANE, height: (x, z) => Math.sin(x / 3) * Math.cos(z / 5) };
    const moved = makeLevel(waves, 0.5);
    for (const [x, z] of [
      [0, 0],
      [9, -4],
      [31, 17],
      [-12, 80],
      [-300, 40],
      [-280, 55],
    ] as const)
      moved.level.move(x, z);
    const fresh = makeLevel(waves, 0.5);
    fresh.level.move(-280, 55);
    expect(moved.data.heights).toEqual(fresh.data.heights);
    expect(moved.data.kinds).toEqual(fresh.data.kinds);
    expect(moved.level.middle).toEqual(fresh.level.middle);
  });

  it("gives the gradient of a plane everywhere, also along the edges", () => {
    const { level, data } = makeLevel(PLANE, 1);
    level.move(40, 0);
    level.move(60, -30);
    for (let k = 0; k < data.slopes.length; k += 2) {
      // 1/4 and 1/2 are exact as half floats, heights of this plane exact in float32.
      expect(DataUtils.fromHalfFloat(data.slopes[k]!)).toBe(0.25);
      expect(DataUtils.fromHalfFloat(data.slopes[k + 1]!)).toBe(-0.5);
    }
  });

  it("stays where it is for small steps", () => {
    const { level } = makeLevel(PLANE, 0.5);
    expect(level.move(0, 0)).toBe(true);
    expect(level.move(0.9, -0.9)).toBe(false);
    expect(level.move(1.1, 0)).toBe(true);
  });
});

describe("repaint", () => {
  it("asks for the kinds anew, and leaves the heights", () => {
    let ice = 0;
    const { level, data } = makeLevel({ ...PLANE, kinds: () => [1 - ice, 0, ice] }, 0.5);
    level.move(13, -70);
    const heights = data.heights.slice();
    ice = 1;
    level.repaint();
    expect(data.heights).toEqual(heights);
    expect(data.kinds.filter((_, k) => k % 4 === 2).every((value) => value === 255)).toBe(true);
  });
});
