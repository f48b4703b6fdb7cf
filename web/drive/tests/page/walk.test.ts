/** The example of docs/game_snow.md: a character of one's own leaves its feet in the snow. */
import { afterAll, beforeAll, describe, expect, it } from "vitest";
import type { WalkPage } from "../../src/example/walk";
import { NO_BROWSER, visit, type Visit } from "./browser";

declare global {
  interface Window {
    walkOnSnow: WalkPage;
  }
}

describe.skipIf(NO_BROWSER)("the example", () => {
  let walk: Visit;
  beforeAll(async () => {
    walk = await visit("walk.html", { width: 240, height: 160, search: "?held" });
  });
  afterAll(() => walk.close());

  it("leaves footprints 4 cm above the ground, left and right, and costs what it says", async () => {
    const found = await walk.page.evaluate(async () => {
      const { field, walk: step, draw, cost } = window.walkOnSnow;
      for (let i = 0; i < 90; i++) step(1 / 60);
      draw();
      const nz = 16;
      const data = await field.read(-0.1, -0.32, 64, nz);
      const least = [0, 1].map((side) => {
        const rows = Array.from({ length: nz / 2 }, (_, j) => (j + (side * nz) / 2) * 64);
        return Math.min(...rows.flatMap((row) => Array.from({ length: 64 }, (_, i) => data[2 * (row + i)]!)));
      });
      return { least, cost: cost() };
    });
    for (const h of found.least) {
      expect(h).toBeGreaterThan(0.03); // a little snow slides off the walls, none goes below the sole
      expect(h).toBeLessThan(0.12); // of 0.25 m
    }
    expect(found.cost.textureBytes).toBeGreaterThan(512 * 512 * 8);
    expect(found.cost.updateBytes).toBeLessThan(8e6);
    expect(walk.errors).toEqual([]);
  });
});
