import { afterAll, afterEach, beforeAll, describe, expect, test } from "vitest";
import { press, standingSlope } from "../../src/snow/law";
import type { Stamp } from "../../src/snow/stamps";
import { NO_BROWSER } from "./browser";
import { differing, EPS, N, SnowVisit, sums, TEXEL, wheelAt } from "./snow_visit";

describe.skipIf(NO_BROWSER)("the snow field", () => {
  let field: SnowVisit;
  beforeAll(async () => {
    field = await SnowVisit.open();
  });
  afterAll(async () => {
    await field.visit.close();
  });
  afterEach(() => {
    expect(field.visit.errors).toEqual([]);
  });

  test("begins fresh, by depth and cover", async () => {
    await field.start({ patchy: true });
    const snow = await field.all();
    const corner = await field.visit.page.evaluate(() => window.snow.field!.corner);
    expect(corner).toEqual({ x: -6.4, z: -6.4 });
    for (const [i, j] of [
      [0, 0],
      [100, 37],
      [255, 255],
      [63, 64],
    ] as const) {
      const [x, z] = [corner.x + (i + 0.5) * TEXEL, corner.z + (j + 0.5) * TEXEL];
      const fresh = 0.5 * (1 + 0.3 * Math.sin(0.7 * x) * Math.cos(0.5 * z));
      // Linear between points 0.4 m apart: at most d^2/8 of the second derivative 0.15 * 0.49, in both directions.
      expect(Math.abs(snow[2 * (i + N * j)]! - fresh)).toBeLessThan((0.4 ** 2 / 8) * 0.15 * (0.49 + 0.25));
      expect(snow[2 * (i + N * j) + 1]).toBe(snow[2 * (i + N * j)]);
    }
  });

  test("a wheel presses by its underside, by the law", async () => {
    await field.start();
    await field.update(0, [wheelAt(0.025, 0.025, 0.2, { heading: 0 })]);
    const [h, W] = [...(await field.read(0, 0))] as [number, number];
    expect(Math.abs(h - 0.2)).toBeLessThan(1e-6);
    // GPUs may round exp2 and log2, of which pow is made, at 2^-21 or so.
    expect(Math.abs(W - press({ h: 0.5, W: 0.5 }, 0.2, 0.6).W)).toBeLessThan(1e-5);
    const [side] = [...(await field.read(0.2, 0))] as [number, number];
    expect(Math.abs(side - (0.2 + 0.38 - Math.sqrt(0.38 ** 2 - 0.2 ** 2)))).toBeLessThan(1e-6);
  });

  test("columns that are written are there, across the seam of the texture too; outside the window none are", async () => {
    await field.start();
    const [nx, nz] = [200, 90];
    const written = Array.from({ length: 2 * nx * nz }, (_, k) => Math.fround(0.1 + 1e-5 * k));
    const answers = await field.visit.page.evaluate(
      async ([data, wide]) => {
        const { field: snow } = window.snow;
        snow!.follow(7, 5); // two tiles on: the window begins in the middle of the texture
        snow!.update(0, []);
        const { x, z } = snow!.corner;
        const to = [x + 1, z + 2] as const;
        const there = snow!.write(...to, wide, new Float32Array(data));
        const beyond = snow!.write(x - 0.5, z, wide, new Float32Array(data));
        return [there, beyond, Array.from(await snow!.read(...to, wide, data.length / (2 * wide)))] as const;
      },
      [written, nx] as const,
    );
    expect(answers[0]).toBe(true);
    expect(answers[1]).toBe(false);
    expect(answers[2]).toEqual(written);
  });

  test("stamps aside press like the others, and leave no print with the processor", async () => {
    await field.start();
    const stamp = wheelAt(0.525, 0.025, 0.2);
    const [h, column] = await field.visit.page.evaluate(async (aside) => {
      const { field: snow } = window.snow;
      snow!.update(0, [], [aside]);
      return [(await snow!.read(aside.x, aside.z, 1, 1))[0]!, snow!.column(aside.x, aside.z).h] as const;
    }, stamp);
    expect(Math.abs(h - 0.2)).toBeLessThan(1e-6);
    expect(column).toBe(0.5);
  });

  test("stamping twice equals stamping once, bit for bit", async () => {
    const stamps: Stamp[] = [
      wheelAt(1.1, 0.8, 0.15, { slip: 2 }),
      wheelAt(1.4, -0.8, 0.2, { from: { x: 0.7, y: 0.6, z: -1 } }),
      wheelAt(-1.4, 0.8, -0.4),
      {
        shape: "box",
        x: -0.3,
        y: 0.4,
        z: 0.1,
        heading: 0.3,
        length: 2,
        width: 1,
        slopeAlong: 0.05,
        slopeAcross: -0.1,
      },
    ];
    await field.start({ patchy: true });
    await field.update(0, stamps);
    const once = await field.all();
    await field.update(0, stamps);
    expect(differing(await field.all(), once)).toBe(0);
    expect(sums(once).h).toBeLessThan(N * N * 0.5);
  });

  test.each([
    ["a wheel", [wheelAt(0, 0, 0.2)]],
    ["a spinning wheel", [wheelAt(0, 0, 0.05, { slip: 10 })]],
    ["a rolling wheel", [wheelAt(0.4, 0.1, 0.2, { from: { x: 0, y: 0.58, z: 0 } })]],
    [
      "four wheels and the chassis",
      [
        wheelAt(1.3, 0.8, 0.2),
        wheelAt(1.3, -0.8, 0.18),
        wheelAt(-1.3, 0.8, 0.21),
        wheelAt(-1.3, -0.8, 0.2),
        {
          shape: "box",
          x: 0,
          y: 0.35,
          z: 0,
          heading: 0.3,
          length: 3,
          width: 1.2,
          slopeAlong: 0,
          slopeAcross: 0,
        },
      ],
    ],
  ] as [string, Stamp[]][])(
    "%s: rims are what was displaced times (1 - compaction), mass stays",
    async (_, stamps) => {
      await field.start();
      await field.update(0, stamps);
      const snow = await field.all();
      let [displaced, rim] = [0, 0];
      for (let i = 0; i < snow.length; i += 2) {
        if (snow[i]! < 0.5) displaced += 0.5 - snow[i]!;
        else rim += snow[i]! - 0.5;
      }
      expect(displaced).toBeGreaterThan(5);
      // Sums of some thousand numbers in float32, one after the other in 64 lanes; the promise is 2 %.
      expect(Math.abs(rim / (0.4 * displaced) - 1)).toBeLessThan(1e-4);
      expect(Math.abs(sums(snow).W / (N * N * 0.5) - 1)).toBeLessThan(1e-6);
    },
  );

  test("the second of two different stamps presses only what the first left", async () => {
    await field.start({ settings: { compaction: 1 } });
    await field.update(0, [wheelAt(0, 0, 0.3)]);
    await field.update(0, [wheelAt(0, 0, 0.2)]);
    const twice = await field.all();
    await field.start({ settings: { compaction: 1 } });
    await field.update(0, [wheelAt(0, 0, 0.2)]);
    expect(differing(await field.all(), twice)).toBe(0);
  });

  test("sliding conserves volume and mass, and ends", async () => {
    await field.start();
    await field.update(0, [wheelAt(0, 0, 0.1), wheelAt(0.2, 0.8, 0.05)]);
    const before = sums(await field.all());
    await field.relax(200);
    const settled = await field.all();
    const after = sums(settled);
    // Each of 200 steps rounds the few thousand texels that move by EPS or so, in any direction.
    expect(Math.abs(after.h - before.h)).toBeLessThan(200 * 3000 * EPS);
    expect(Math.abs(after.W - before.W)).toBeLessThan(200 * 3000 * EPS);
    await field.relax(20);
    expect(differing(await field.all(), settled)).toBe(0);
  });

  /** The largest slope of the surface between neighbours as a multiple of what may stand there. */
  const steepest = (snow: Float32Array, [a, b]: [number, number], repose: number, loose: boolean) => {
    const ratio = (i: number) => (snow[i]! > 1e-6 ? snow[i + 1]! / snow[i]! : 1);
    let most = 0;
    for (let z = 0; z < N - 1; z++)
      for (let x = 1; x < N - 1; x++)
        for (const [dx, dz] of [
          [1, 0],
          [0, 1],
          [1, 1],
          [-1, 1],
        ] as const) {
          const [i, j] = [2 * (x + N * z), 2 * (x + dx + N * (z + dz))];
          const densest = Math.max(ratio(i), ratio(j));
          if (loose && densest > 1.001) continue;
          const drop = snow[i]! - snow[j]! - TEXEL * (a * dx + b * dz);
          const slope = Math.abs(drop) / (TEXEL * Math.hypot(dx, dz));
          most = Math.max(most, slope / standingSlope(repose, densest));
        }
    return most;
  };

  test.each([
    [[0, 0], 42],
    [[0, 0], 25],
    [[0.35, 0.3], 38],
  ] as [[number, number], number][])(
    "no slope stays above the angle of repose: ground rising by %j, repose %i degrees",
    async (slope, repose) => {
      await field.start({ slope, settings: { repose } });
      const ground = (x: number, z: number) => slope[0] * x + slope[1] * z;
      // Deep and packed, and a second heap of rims beside it; then a hole to the ground.
      const stamps = [
        wheelAt(0, 0, ground(0, 0) + 0.03),
        wheelAt(0.1, 0.6, ground(0.1, 0.6) + 0.1, { slip: 8 }),
        wheelAt(-0.9, -0.6, ground(-0.9, -0.6) - 0.3),
      ];
      await field.update(0, stamps);
      expect(steepest(await field.all(), slope, repose, false)).toBeGreaterThan(1.5);
      const snow = await field.atRest();
      // The surface is known to float32: 2^-24 of some metres over 5 cm.
      expect(steepest(snow, slope, repose, false)).toBeLessThan(1 + 1e-4);
      expect(steepest(snow, slope, repose, true)).toBeLessThan(1 + 1e-4);
      expect(Math.abs(sums(snow).W / (N * N * 0.5) - 1)).toBeLessThan(1e-6);
    },
  );

  test("fresh snow on ground steeper than repose stays as it fell", async () => {
    await field.start({ slope: [1.5, 0], patchy: true });
    const fresh = await field.all();
    await field.relax(10);
    expect(differing(await field.all(), fresh)).toBe(0);
  });

  test("a car that drives leaves two ruts with rims, in time too", async () => {
    await field.start();
    await field.visit.page.evaluate(() => {
      const field = window.snow.field!;
      const wheel = (x: number, z: number, from: number) => ({
        shape: "wheel" as const,
        x,
        y: 0.2 + 0.38,
        z,
        heading: 0,
        radius: 0.38,
        width: 0.26,
        slip: 0,
        from: { x: from, y: 0.58, z },
      });
      for (let i = 0; i < 40; i++) {
        const [x, from] = [-3 + 0.15 * i, -3 + 0.15 * Math.max(0, i - 1)];
        field.update(1 / 60, [wheel(x, 0.8, from), wheel(x, -0.8, from)]);
      }
    });
    const snow = await field.all();
    const across = Array.from({ length: N }, (_, j) => snow[2 * (N / 2 + N * j)]!);
    const at = (z: number) => across[Math.floor((z + 6.4) / TEXEL)]!;
    expect(at(0.8)).toBeLessThan(0.3);
    expect(at(-0.8)).toBeLessThan(0.3);
    expect(at(0)).toBeGreaterThan(0.499);
    expect(at(3)).toBe(0.5);
    expect(Math.max(...across)).toBeGreaterThan(0.52);
    // The same left and right of the car: mirrored texels differ by rounding and by what slides first, or not at all.
    for (let j = 0; j < N; j++) expect(Math.abs(across[j]! - across[N - 1 - j]!)).toBeLessThan(1e-4);
  });
});
