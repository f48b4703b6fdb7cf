import { afterAll, afterEach, beforeAll, describe, expect, test } from "vitest";
import { NO_BROWSER } from "./browser";
import { differing, EPS, SnowVisit, wheelAt } from "./snow_visit";

/** Depth and mass of the snow where the wheel stood, right after it. */
const RUT = 0.2;

describe.skipIf(NO_BROWSER)("snow in time", () => {
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

  const rut = async () => [...(await field.read(0, 0))] as [number, number];

  test.each([20, 60, 144])("at %i updates a second tracks recover by exp(-t / tau)", async (rate) => {
    await field.start({ settings: { recovery: 4 } });
    await field.update(0, [wheelAt(0.025, 0.025, RUT)]);
    const [h0, W0] = await rut();
    const rim0 = (await field.read(0, -0.3))[0]!;
    expect(h0).toBeLessThan(0.21);
    expect(rim0).toBeGreaterThan(0.505);
    for (const seconds of [1, 2]) {
      await field.update(1 / rate, [], rate);
      const [h, W] = await rut();
      const left = Math.exp(-seconds / 4);
      // Each turn rounds a number near 1/2, and gain, which the GPU gets in float32, by EPS.
      const tolerance = 2 * rate * seconds * EPS;
      expect(Math.abs(0.5 - h - (0.5 - h0) * left)).toBeLessThan(tolerance);
      expect(Math.abs(0.5 - W - (0.5 - W0) * left)).toBeLessThan(tolerance);
      const rim = (await field.read(0, -0.3))[0]!;
      expect(Math.abs(rim - 0.5 - (rim0 - 0.5) * left)).toBeLessThan(tolerance);
    }
  });

  test.each([20, 60])("at %i updates a second falling snow fills tracks in a straight line", async (rate) => {
    await field.start({ settings: { snowfall: 0.1 } });
    await field.update(0, [wheelAt(0.025, 0.025, RUT)]);
    const [h0, W0] = await rut();
    for (const seconds of [1, 2]) {
      await field.update(1 / rate, [], rate);
      const [h, W] = await rut();
      expect(Math.abs(h - h0 - 0.1 * seconds)).toBeLessThan(2 * rate * seconds * EPS);
      expect(Math.abs(W - W0 - 0.1 * seconds)).toBeLessThan(2 * rate * seconds * EPS);
    }
    await field.update(1 / rate, [], 2 * rate);
    expect((await rut())[0]).toBe(0.5);
  });

  test("with neither, tracks stay bit for bit", async () => {
    await field.start();
    await field.update(0, [wheelAt(0, 0, RUT)]);
    const before = await field.all();
    await field.update(10, [], 50);
    expect(differing(await field.all(), before)).toBe(0);
  });

  test("a wheel that stands changes nothing once its walls have slid", async () => {
    await field.start();
    const stamps = [wheelAt(0, 0, 0.2), wheelAt(0.5, 1, 0.1)];
    await field.update(1 / 60, stamps, 300);
    const before = await field.all();
    await field.update(1 / 60, stamps, 20);
    expect(differing(await field.all(), before)).toBe(0);
  });

  test("a new depth scales all snow, tracks as well", async () => {
    await field.start();
    await field.update(0, [wheelAt(0.025, 0.025, RUT)]);
    const before = await field.all();
    await field.visit.page.evaluate(() => (window.snow.field!.settings.depth = 0.25));
    await field.update(1 / 60);
    expect(
      differing(
        await field.all(),
        before.map((a) => a / 2),
      ),
    ).toBe(0);
  });

  test("what is probed is what is there", async () => {
    await field.start();
    await field.update(0, [wheelAt(0.025, 0.025, RUT)]);
    await field.visit.page.waitForFunction(() => window.snow.field!.probe(0.025, 0.025) !== null);
    const probed = await field.visit.page.evaluate(() => window.snow.field!.probe(0.025, 0.025));
    const [h, W] = await rut();
    // Asked for in the middle of a texel, up to the rounding of 0.025 / 0.05.
    expect(probed!.h).toBeCloseTo(h, 6);
    expect(probed!.W).toBeCloseTo(W, 6);
    expect(await field.visit.page.evaluate(() => window.snow.field!.probe(3, 0))).toBeNull();
  });

  test("a window of 1024 texels moves less than 8 MB in each update, with four wheels at 20 m/s", async () => {
    await field.start({ resolution: 1024, settings: { recovery: 20, snowfall: 1e-3 } });
    const bytes = await field.visit.page.evaluate(() => {
      const snow = window.snow.field!;
      const list: number[] = [];
      const corners = [
        [1.3, 0.8],
        [1.3, -0.8],
        [-1.3, 0.8],
        [-1.3, -0.8],
      ] as const;
      for (let i = 0; i < 60; i++) {
        const at = (i * 20) / 60;
        snow.follow(at, at / 2);
        const stamps = corners.map(([x, z]) => ({
          shape: "wheel" as const,
          x: at + x,
          y: 0.58,
          z: at / 2 + z,
          heading: Math.atan(0.5),
          radius: 0.38,
          width: 0.26,
          slip: 1,
          from: { x: at + x - 1 / 3, y: 0.58, z: at / 2 + z - 1 / 6 },
        }));
        snow.update(1 / 60, stamps);
        list.push(snow.bytesPerUpdate);
      }
      return { list, textures: snow.textureBytes, draws: snow.drawCalls };
    });
    // The first update makes the window: `start` did it. Sliding came in several of these.
    expect(Math.max(...bytes.list)).toBeLessThan(8e6);
    // Four wheels with their rims cover at least 4 m2, each texel read (16 bytes) and written (8) by four passes.
    expect(Math.min(...bytes.list)).toBeGreaterThan((4 / 0.05 ** 2) * 24 * 4);
    expect(bytes.textures).toBeLessThan(26e6);
    console.log("bytes per update", Math.min(...bytes.list), Math.max(...bytes.list), "draws", bytes.draws);
  });
});
