/** The page that begins on ground on which Neve has let it snow. */
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { readFile } from "node:fs/promises";
import { readGround } from "../../src/bridge/ground";
import { NO_BROWSER, type Visit } from "./browser";
import { openDemo } from "./demo_visit";

const FILE = new URL("../../public/grounds/snowed_slope.json", import.meta.url);

describe.skipIf(NO_BROWSER)("the page on snowed ground", () => {
  let visitor: Visit;
  beforeAll(async () => {
    visitor = await openDemo("resolution=256&flakes=0&detail=low&ground=snowed_slope");
  });
  afterAll(async () => {
    await visitor.close();
  });

  test("has the texture's snow, as deep as it lies on each cell", async () => {
    const { nx, ny, cell, depth } = await readGround(await readFile(FILE, "utf8"));
    const cells = [
      [nx / 2 + 4, ny / 2 + 3],
      [nx / 2 - 6, ny / 2 - 5],
      [nx / 2 + 9, ny / 2 - 8],
    ] as const;
    for (const [i, j] of cells) {
      // On the lattice, between four cells.
      const [x, z] = [(i - nx / 2) * cell, -(j - ny / 2) * cell];
      const mean = [0, 1, 2, 3].reduce((sum, k) => sum + depth[(i - (k >> 1)) * ny + j - (k & 1)]!, 0) / 4;
      const [h, W] = await visitor.page.evaluate(
        async ([x, z]) => {
          const demo = window.neveDrive!;
          demo.field.update(0, []);
          return [...(await demo.field.read(x, z, 1, 1))];
        },
        [x, z] as const,
      );
      // The texel is up to 0.1 m off the lattice point, the depth changes by less than 0.2 m/m.
      expect(Math.abs(h! - mean)).toBeLessThan(0.02);
      expect(W).toBeCloseTo(h!, 5);
    }
  });

  test("carries the car, which leaves ruts", async () => {
    const [far, sinkage, error, others] = await visitor.page.evaluate(() => {
      const demo = window.neveDrive!;
      demo.drive(1, {});
      demo.drive(3, { throttle: 0.6 });
      const [x, y, z] = demo.car.state.position;
      return [
        [Math.hypot(x, z), y - demo.terrain.height(x, z)],
        Math.max(...demo.car.state.wheels.map((wheel) => wheel.sinkage)),
        document.getElementById("message")!.textContent,
        demo.company.sight().other,
      ] as const;
    });
    expect(far[0]).toBeGreaterThan(2);
    expect(far[1]).toBeGreaterThan(0);
    expect(far[1]).toBeLessThan(2);
    expect(sinkage).toBeGreaterThan(0.02);
    expect(error).toContain("handbrake");
    expect(others).toBeNull();
    expect(visitor.errors).toEqual([]);
  });
});
