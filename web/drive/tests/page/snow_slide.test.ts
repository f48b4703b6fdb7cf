import { afterAll, afterEach, beforeAll, describe, expect, test } from "vitest";
import { NO_BROWSER } from "./browser";
import { differing, EPS, N, SnowVisit, wheelAt } from "./snow_visit";

describe.skipIf(NO_BROWSER)("the sliding window of the snow", () => {
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

  /** Tracks in several tiles, packed, piled and half slid. */
  const track = async (x = 0, z = 0) => {
    await field.update(0, [
      wheelAt(x, z, 0.1),
      wheelAt(x + 2.9, z - 3.3, 0.2, { slip: 4 }),
      wheelAt(x - 5, z + 4, 0.05),
    ]);
    await field.update(1 / 60, [wheelAt(x + 1, z + 1, 0.15)]);
    return field.read(x - 6.4, z - 6.4, N);
  };
  const stored = () => field.visit.page.evaluate(() => window.snow.field!.storedTiles);

  test.each([
    ["one tile away", [[3.5, 0]]],
    ["several windows away", [[60, 0]]],
    ["aslant", [[-41, 77]]],
    [
      "by many small steps",
      [
        [5, 5],
        [11, 8],
        [17, 17],
        [30, 22],
        [22, 11],
        [9, 9],
      ],
    ],
    [
      "around",
      [
        [14, 0],
        [14, 14],
        [0, 14],
        [-14, 14],
        [-14, -14],
      ],
    ],
  ] as [string, [number, number][]][])("loses nothing when it moves %s and back", async (_, way) => {
    await field.start({ patchy: true });
    const before = await track();
    for (const [x, z] of way) {
      await field.follow(x, z);
      await field.read(x, z);
    }
    await field.follow(0, 0);
    expect(differing(await field.read(-6.4, -6.4, N), before)).toBe(0);
  });

  test("loses nothing when it is back before its tiles were read", async () => {
    await field.start({ patchy: true });
    const before = await track();
    await field.visit.page.evaluate(() => {
      const snow = window.snow.field!;
      for (const [x, z] of [
        [20, 0],
        [0, 0],
        [0, -30],
        [3.3, 0],
        [-20, -20],
        [0, 0],
      ] as const) {
        snow.follow(x, z);
        snow.update(0, []);
      }
    });
    expect(differing(await field.read(-6.4, -6.4, N), before)).toBe(0);
  });

  test("keeps tracks of several places, and only tiles that have some", async () => {
    await field.start();
    const first = await track();
    await field.follow(80, 80);
    await field.read(80, 80);
    const tiles = await stored();
    expect(tiles).toBeGreaterThan(3);
    expect(tiles).toBeLessThan(16);
    const second = await track(80, 80);
    await field.follow(0, 0);
    expect(differing(await field.read(-6.4, -6.4, N), first)).toBe(0);
    await field.follow(80, 80);
    expect(differing(await field.read(73.6, 73.6, N), second)).toBe(0);
  });

  test("four kilometres from the start tracks are the same as at the start", async () => {
    await field.start();
    const near = await track();
    // A multiple of the texel and of the tile: the same place within a tile.
    await field.follow(4000, -3200);
    await field.read(4000, -3200);
    const far = await track(4000, -3200);
    // Places are reckoned from the corner of the window; what is left is their rounding in float32 at 12.8 m times the
    // slope of a wheel's flank, and what pressing and sums make of that.
    const most = far.reduce((worst, a, i) => Math.max(worst, Math.abs(a - near[i]!)), 0);
    expect(most).toBeLessThan(1e-4);
  });

  test("tracks recover while they are away", async () => {
    await field.start({ settings: { recovery: 20 } });
    await field.update(0, [wheelAt(0.025, 0.025, 0.2)]);
    const [h0] = await field.read(0, 0);
    await field.follow(50, 0);
    await field.update(0.5, [], 20);
    await field.follow(0, 0);
    const [h] = await field.read(0, 0);
    expect(Math.abs(0.5 - h! - (0.5 - h0!) * Math.exp(-0.5))).toBeLessThan(16 * EPS);
  });

  test("goes on from its copies after the WebGL context was lost", async () => {
    await field.start({ patchy: true });
    await track();
    // One tile is copied in an update, if it has waited two seconds.
    await field.update(0.2, [], 60);
    const before = await field.read(-6.4, -6.4, N);
    const { page } = field.visit;
    await page.evaluate(
      () =>
        new Promise<void>((done) => {
          const { renderer, field: snow } = window.snow;
          const canvas = renderer.domElement;
          canvas.addEventListener(
            "webglcontextlost",
            () => {
              // Updates without a context do nothing, and do not throw.
              snow!.update(0.1, []);
              setTimeout(() => renderer.forceContextRestore(), 50);
            },
            { once: true },
          );
          canvas.addEventListener("webglcontextrestored", () => done(), { once: true });
          renderer.forceContextLoss();
        }),
    );
    await field.update(0);
    expect(differing(await field.read(-6.4, -6.4, N), before)).toBe(0);
    // And it still works: presses, slides the window, comes back.
    await field.update(0, [wheelAt(2, 2, 0.1)]);
    const pressed = await field.read(-6.4, -6.4, N);
    expect(differing(pressed, before)).toBeGreaterThan(0);
    await field.follow(40, 0);
    await field.follow(0, 0);
    expect(differing(await field.read(-6.4, -6.4, N), pressed)).toBe(0);
  });
});
