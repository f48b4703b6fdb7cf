/** What the module gives to pages of others: feet, silhouettes, and files that engines read. */
import { inflateSync } from "node:zlib";
import { BoxGeometry, SphereGeometry, FloatType } from "three";
import { EXRLoader } from "three/examples/jsm/loaders/EXRLoader.js";
import { describe, expect, it } from "vitest";
import { depthPng, snowExr } from "../../src/snow/export/textures";
import { footStamps } from "../../src/snow/foot";
import { underside } from "../../src/snow/prints";
import { silhouetteStamps } from "../../src/snow/silhouette";
import type { Stamp } from "../../src/snow/stamps";

const lowest = (stamps: readonly Stamp[], x: number, z: number) =>
  Math.min(...stamps.map((stamp) => underside(stamp, x, z)));

describe("footStamps", () => {
  const foot = { x: 1, y: 0.05, z: 2, heading: 0.6 };
  const [c, s] = [Math.cos(0.6), Math.sin(0.6)];
  const under = (along: number, across: number, more = {}) =>
    lowest(footStamps({ ...foot, ...more }), 1 + c * along - s * across, 2 + s * along + c * across);

  it("is a sole of 0.29 m: ball wider than heel, the arch a little higher, nothing beside it", () => {
    expect(footStamps(foot)).toHaveLength(4);
    expect(under(-0.1, 0)).toBeCloseTo(0.05, 12);
    expect(under(0.06, 0)).toBeCloseTo(0.05, 12);
    expect(under(-0.01, 0)).toBeCloseTo(0.05 + 0.02 * 0.29, 12);
    expect(under(0.06, 0.052)).toBeCloseTo(0.05, 12);
    expect(under(-0.1, 0.052)).toBe(Infinity);
    expect(under(0.15, 0)).toBe(Infinity);
  });

  it("lifts the heel while it rolls off, and leaves the toes on the ground", () => {
    expect(under(-0.145 + 1e-9, 0, { heel: 0.1 })).toBeCloseTo(0.15, 6);
    expect(under(0.06, 0, { heel: 0.1 })).toBeCloseTo(0.05, 12);
  });
});

describe("silhouetteStamps", () => {
  it("is one box for a box, and presses nothing above the snow", () => {
    const box = new BoxGeometry(0.4, 0.2, 0.6).translate(1, 0.3, -1);
    const shape = { positions: box.attributes["position"]!.array, index: box.index!.array, cell: 0.05 };
    const stamps = silhouetteStamps({ ...shape, below: 1 });
    expect(stamps).toHaveLength(1);
    expect(stamps[0]).toMatchObject({ shape: "box", heading: 0 });
    expect(lowest(stamps, 1.19, -0.71)).toBeCloseTo(0.2, 6);
    expect(lowest(stamps, 1.21, -1)).toBe(Infinity);
    expect(silhouetteStamps({ ...shape, below: 0.2 })).toEqual([]);
    expect(() => silhouetteStamps({ ...shape, cell: 1e-5, below: 1 })).toThrow("too large");
    expect(() => silhouetteStamps({ ...shape, cell: 0, below: 1 })).toThrow("greater than 0");
  });

  it("follows the underside of a ball to the tolerance and the slope over half a cell", () => {
    const [cell, tolerance, R] = [0.02, 0.01, 0.5];
    const ball = new SphereGeometry(R, 96, 64).translate(0, R, 0);
    const shape = {
      positions: ball.attributes["position"]!.array,
      index: ball.index!.array,
      cell,
      tolerance,
    };
    const stamps = silhouetteStamps({ ...shape, below: 0.2 });
    for (const [x, z] of [
      [0.01, 0.01],
      [0.21, 0.01],
      [-0.11, 0.19],
      [0.25, -0.21],
    ] as const) {
      const square = x * x + z * z;
      const exact = R - Math.sqrt(R * R - square);
      const slope = Math.sqrt(square / (R * R - square));
      // A box has the lowest height of its cells: below by twice the tolerance, above by the facets of the ball.
      const facets = R * (1 - Math.cos(Math.PI / 64));
      expect(lowest(stamps, x, z) - exact).toBeLessThanOrEqual(slope * cell + facets);
      expect(exact - lowest(stamps, x, z)).toBeLessThanOrEqual(2 * tolerance + slope * cell + facets);
    }
    expect(lowest(stamps, 0.41, 0)).toBe(Infinity); // there the ball is higher than 0.2 m
  });
});

describe("files", () => {
  const pixels = { width: 3, height: 2, data: Float32Array.from({ length: 12 }, (_, k) => 0.05 * k) };

  it("PNG: 16 bits of grey and alpha, white at the depth that was asked for", async () => {
    const png = Buffer.from(await depthPng(pixels, 0.5));
    expect(png.subarray(1, 4).toString()).toBe("PNG");
    expect([png.readUInt32BE(16), png.readUInt32BE(20), png[24], png[25]]).toEqual([3, 2, 16, 4]);
    const at = png.indexOf("IDAT");
    const rows = inflateSync(png.subarray(at + 4, at + 4 + png.readUInt32BE(at - 4)));
    for (let j = 0; j < 2; j++)
      for (let k = 0; k < 6; k++)
        expect(rows.readUInt16BE(j * 13 + 1 + 2 * k)).toBe(
          Math.round(65535 * Math.min(1, pixels.data[6 * j + k]! / 0.5)),
        );
    await expect(depthPng(pixels, 0)).rejects.toThrow("greater than 0");
    await expect(depthPng({ ...pixels, width: 4 }, 1)).rejects.toThrow("needs as many");
  });

  it("EXR: what another reader finds is the same to the bit", () => {
    const bytes = snowExr(pixels);
    const loader = new EXRLoader().setDataType(FloatType);
    const read = loader.parse(bytes.buffer as ArrayBuffer) as {
      width: number;
      height: number;
      data: Float32Array;
    };
    expect([read.width, read.height]).toEqual([3, 2]);
    const step = read.data.length / 6;
    for (let j = 0; j < 2; j++)
      for (let i = 0; i < 3; i++) {
        const there = step * (i + (1 - j) * 3); // this reader turns pictures upside down
        expect(read.data[there]).toBe(pixels.data[2 * (i + 3 * j)]);
        expect(read.data[there + 1]).toBe(pixels.data[2 * (i + 3 * j) + 1]);
        expect(read.data[there + 2]).toBeGreaterThanOrEqual(1);
      }
  });
});
