/** What came to the page beside the car: a recording of a run, the course, photos, sound, the bar while it loads. */
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import type { Demo } from "../../src/demo";
import { NO_BROWSER, type Visit } from "./browser";
import { hear, openDemo, STILL } from "./demo_visit";

const SETTINGS = "resolution=256&flakes=0&recording=wheel_load&photo=1920&hour=14&snowfall=-1&type=slush";

/** Sizes of a window [pixels], and the corners of the page with words. */
const SIZES = [
  [1280, 720],
  [900, 510],
  [390, 700],
] as const;
const CORNERS = ["dash", "figures", "course", "bridge", "message"];

describe.skipIf(NO_BROWSER)("the page with a recording", () => {
  let visitor: Visit;
  beforeAll(async () => {
    visitor = await openDemo(SETTINGS, { width: 800, height: 480, touch: true });
  });
  afterAll(async () => {
    await visitor.close();
  });

  test("is loaded: the bar is gone, the panel is closed, and the snow is that of the run", async () => {
    const { page } = visitor;
    const [hidden, depth, compaction] = await page.evaluate(() => [
      document.getElementById("loading")!.hidden,
      window.neveDrive!.settings.depth,
      window.neveDrive!.settings.compaction,
    ]);
    expect(hidden).toBe(true);
    expect(depth).toBeCloseTo(0.31, 2);
    expect(compaction).toBeCloseTo(0.41, 2);
    const title = page.getByRole("button", { name: "Snow and car" });
    expect(await title.getAttribute("aria-expanded")).toBe("false"); // the picture is not hidden by the panel
  });

  test("tells what is wrong with its address, and takes the rest", async () => {
    const { page } = visitor;
    expect(await page.locator("#message").textContent()).toBe(
      "snowfall: -1 is not a number from 0 to 200 mm/min.\ntype: slush is not one of map, powder, packed, ice.",
    );
    const settings = await page.evaluate(() => window.neveDrive!.settings);
    expect([settings.snowfall, settings.type, settings.hour]).toEqual([0, "map", 14]);
  });

  test("plays the run's columns in the snow, and the game's rut beside them", async () => {
    const [recorded, game, fresh] = await visitor.page.evaluate(async (still) => {
      const demo = window.neveDrive!;
      // To the end of the run, before it begins again.
      for (let n = 0; n < 110; n++) demo.advance(1 / 60, still);
      const depth = async (z: number) => (await demo.field.read(2.2 + 1.2, z, 1, 1))[0]!;
      return [await depth(2.6), await depth(2.6 + 1.5), await depth(2.6 + 0.75)];
    }, STILL);
    expect(recorded!).toBeLessThan(0.8 * fresh!);
    expect(game!).toBeLessThan(0.8 * fresh!);
    // The law's sinkage differs from that of the run by 2.7 cm on the whole; slides fill a rut a little.
    expect(Math.abs(game! - recorded!)).toBeLessThan(0.08);
  });

  test("says the load and the sinkage by both methods", async () => {
    expect(await hear(visitor.page, "bridge", "kN")).toMatch(
      /wheel_load: \d\.\d kN[^]*material point method: \d+\.\d cm[^]*game: \d+\.\d cm/,
    );
  });

  test("P holds the world still, Enter saves a picture, P goes on", async () => {
    const { page } = visitor;
    const both = () => page.evaluate(() => JSON.stringify(window.neveDrive!.company.both()));
    await page.evaluate(() => (window.neveDrive!.held = false));
    await page.keyboard.press("KeyP");
    await page.waitForFunction(() => document.body.classList.contains("photo"));
    for (const id of ["dash", "bridge"]) expect(await page.locator(`#${id}`).isVisible()).toBe(false);
    const before = await both();
    await page.evaluate(async () => {
      for (let n = 0; n < 10; n++) await new Promise((next) => requestAnimationFrame(next));
    });
    expect(await both()).toBe(before);
    const saved = page.waitForEvent("download");
    await page.keyboard.press("Enter");
    expect((await saved).suggestedFilename()).toMatch(/^neve-drive-.*\.png$/);
    await page.waitForFunction(() =>
      document.getElementById("message")!.textContent!.includes("1920 × 1152"),
    );
    await page.keyboard.press("KeyP");
    await page.waitForFunction(() => !document.body.classList.contains("photo"));
    expect(await page.evaluate(() => window.neveDrive!.cameras.name)).toBe("chase");
    await page.waitForFunction((stood) => JSON.stringify(window.neveDrive!.company.both()) !== stood, before);
    await page.evaluate(() => (window.neveDrive!.held = true));
  });

  test("without keys the panel begins photo mode, fingers move the camera, and buttons save and end it", async () => {
    const { page } = visitor;
    await page.evaluate(() => (window.neveDrive!.held = false));
    await page.getByRole("button", { name: "Snow and car" }).click();
    await page.getByRole("button", { name: "photo mode (P)" }).click();
    const eye = () => page.evaluate(() => window.neveDrive!.camera.position.toArray());
    const touches = await page.context().newCDPSession(page);
    const touch = (type: "touchStart" | "touchMove" | "touchEnd", ...points: [number, number][]) =>
      touches.send("Input.dispatchTouchEvent", {
        type,
        touchPoints: points.map(([x, y], id) => ({ x, y, id })),
      });
    const away = async () => {
      const [ex, ey, ez] = (await eye()) as [number, number, number];
      const [x, y, z] = await page.evaluate(() => window.neveDrive!.car.state.position);
      return Math.hypot(ex - x, ey - y, ez - z);
    };
    await page.waitForFunction(() => window.neveDrive!.cameras.name === "free");
    const [first, far] = [await eye(), await away()];
    await touch("touchStart", [300, 300]);
    await touch("touchMove", [400, 300]);
    await touch("touchEnd");
    await page.waitForFunction(
      (before) => window.neveDrive!.camera.position.toArray().some((a, k) => Math.abs(a - before[k]!) > 0.5),
      first,
    );
    await touch("touchStart", [300, 300], [400, 300]);
    await touch("touchMove", [250, 300], [450, 300]);
    await touch("touchEnd");
    await expect.poll(away, { timeout: 250_000 }).toBeLessThan(0.8 * far);
    const saved = page.waitForEvent("download");
    await page.getByRole("button", { name: "save picture (Enter)" }).click();
    expect((await saved).suggestedFilename()).toMatch(/\.png$/);
    await page.getByRole("button", { name: "go on (P)" }).click();
    await page.getByRole("button", { name: "Snow and car" }).click();
    expect(await page.evaluate(() => document.body.classList.contains("photo"))).toBe(false);
    await page.evaluate(() => (window.neveDrive!.held = true));
  });

  test("a picture has the size that was asked for, and the canvas keeps its own", async () => {
    const [width, height, same] = await visitor.page.evaluate(async () => {
      const demo = window.neveDrive!;
      const view = document.querySelector("canvas")!;
      const before = [view.width, view.height].join();
      const still = demo.draw;
      delete (demo as Partial<Demo>).draw;
      const blob = await demo.picture(120, 48);
      demo.draw = still;
      const bitmap = await createImageBitmap(blob!);
      return [bitmap.width, bitmap.height, before === [view.width, view.height].join()];
    });
    expect([width, height, same]).toEqual([120, 48, true]);
  });

  test("T puts the car before the course, and the clock begins at the first gate", async () => {
    const { page } = visitor;
    const [before, after] = await page.evaluate((still) => {
      const demo = window.neveDrive!;
      demo.toCourse();
      const { course } = demo.company;
      const idle = course.time;
      for (let n = 0; n < 100 && course.time === null; n++) demo.advance(1 / 20, { ...still, throttle: 0.7 });
      return [idle, course.time];
    }, STILL);
    expect(before).toBeNull();
    expect(after).not.toBeNull();
    expect(await hear(page, "course", "gate")).toMatch(/0:\d\d\.\d {3}gate 0 of 10/);
  });

  test("N switches the sound on and off; it is silent at first", async () => {
    const { page } = visitor;
    for (const words of ["sound on", "sound off"]) {
      await page.keyboard.press("KeyN");
      expect(await hear(page, "message", words)).toBe(words);
    }
  });

  test("its words never lie under each other, however small the window is", async () => {
    const { page } = visitor;
    await page.evaluate((ids) => {
      for (const id of ids) document.getElementById(id)!.hidden = false;
      document.getElementById("figures")!.textContent = "100 draw calls of 150, 400,000 triangles\n".repeat(
        6,
      );
      document.getElementById("message")!.textContent =
        "a sentence that takes some room and another line\n".repeat(2);
    }, CORNERS);
    for (const [width, height] of SIZES) {
      await page.setViewportSize({ width, height });
      const [covered, outside] = await page.evaluate((ids) => {
        const places = ids.map((id) => document.getElementById(id)!);
        const all = [...places, document.querySelector(".lil-title")!];
        const boxes = all.map((place) => [place.id || "panel", place.getBoundingClientRect()] as const);
        const meet = (p: DOMRect, q: DOMRect) =>
          p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom;
        const pairs = boxes.flatMap(([a, p]) =>
          boxes.filter(([b, q]) => a < b && meet(p, q)).map(([b]) => `${a} ${b}`),
        );
        const out = boxes.filter(
          ([, { left, right, bottom }]) => left < 0 || right > innerWidth || bottom > innerHeight,
        );
        return [pairs, out.map(([id]) => id)];
      }, CORNERS);
      expect(covered, `${width} x ${height}`).toEqual([]);
      expect(outside, `${width} x ${height}`).toEqual([]);
    }
  });

  test("nothing was complained about", () => {
    expect(visitor.errors).toEqual([]);
  });
});
