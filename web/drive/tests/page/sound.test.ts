import { afterAll, beforeAll, describe, expect, test } from "vitest";
import type { Mix } from "../../src/page/sound";
import { NO_BROWSER, visit, type Visit } from "./browser";

const SILENT: Mix = { engine: 0, pitch: 60, tyres: 0, crunch: 1000, wind: 0, gust: 400 };

describe.skipIf(NO_BROWSER)("the sound, as the browser makes it", () => {
  let visitor: Visit;
  const hear = (mix: Partial<Mix>) =>
    visitor.page.evaluate((of) => window.sound.hear(of), { ...SILENT, ...mix });
  beforeAll(async () => {
    visitor = await visit("tests/page/sound.html");
    await visitor.page.waitForFunction(() => "sound" in window);
  });
  afterAll(async () => {
    await visitor.close();
  });

  test("is silence where nothing is to be heard", async () => {
    expect((await hear({})).loud).toBeLessThan(1e-6);
  });

  test("of the engine has a pitch that follows the revs", async () => {
    const [slow, fast] = [await hear({ engine: 0.6, pitch: 50 }), await hear({ engine: 0.6, pitch: 200 })];
    expect(slow.loud).toBeGreaterThan(0.02);
    // Four times the frequency: harmonics that the filter lets through add crossings of their own.
    expect(fast.crossings).toBeGreaterThan(2 * slow.crossings);
    expect((await hear({ engine: 0.2, pitch: 50 })).loud).toBeLessThan(slow.loud);
  });

  test("of tyres and wind is noise, duller on deep snow", async () => {
    const [bright, dull] = [
      await hear({ tyres: 0.5, crunch: 1900 }),
      await hear({ tyres: 0.5, crunch: 500 }),
    ];
    expect(bright.loud).toBeGreaterThan(0.01);
    expect(bright.crossings).toBeGreaterThan(1.3 * dull.crossings);
    expect((await hear({ wind: 0.8 })).loud).toBeGreaterThan(0.01);
    expect(visitor.errors).toEqual([]);
  });
});
