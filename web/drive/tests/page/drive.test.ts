import { afterAll, beforeAll, describe, expect, test } from "vitest";
import type { Demo } from "../../src/demo";
import { NO_BROWSER, type Visit } from "./browser";
import { openDemo } from "./demo_visit";
import { ASIDE, CLODS, GLINTS, PAINT, TONES } from "./pictures";

/** Depths of the snow across the track over 4 m, at a place of it [m], and the fresh depths there. */
const ACROSS = async ([x, z]: readonly [number, number]) => {
  const { field, terrain, settings } = window.neveDrive!;
  const n = 80;
  const at = (j: number) => z + (j - n / 2) * field.texel;
  const snow = await field.read(x, at(0), 1, n);
  return Array.from({ length: n }, (_, j) => ({
    z: at(j) - z,
    depth: snow[2 * j]!,
    fresh: settings.depth * terrain.cover(x, at(j)),
  }));
};

/** A place of the track, nearly three metres behind the rear axle. */
const BEHIND = (): [number, number] => {
  const [x, , z] = window.neveDrive!.car.state.position;
  return [x - 4, z];
};

describe.skipIf(NO_BROWSER)("the page", () => {
  let visitor: Visit;
  beforeAll(async () => {
    visitor = await openDemo("resolution=256&flakes=0&others=none");
  });
  afterAll(async () => {
    await visitor.close();
  });

  test("loads, stands still, and draws a picture that is not one colour", async () => {
    const { page } = visitor;
    const colours = await page.evaluate(async () => {
      const demo = window.neveDrive!;
      // The loop draws its frames by itself; from here on none, for the processor would be at nothing else.
      const still = demo.draw;
      delete (demo as Partial<Demo>).draw;
      demo.held = false;
      while (demo.stage.stats.triangles === 0) await new Promise((next) => requestAnimationFrame(next));
      demo.held = true;
      demo.draw = still;
      demo.drive(0.5, {});
      demo.stage.render(demo.camera);
      const view = document.querySelector("canvas")!;
      const copy = Object.assign(document.createElement("canvas"), { width: 32, height: 20 });
      const pen = copy.getContext("2d")!;
      pen.drawImage(view, 0, 0, 32, 20);
      const data = pen.getImageData(0, 0, 32, 20).data;
      return new Set(Array.from({ length: 640 }, (_, i) => data.slice(4 * i, 4 * i + 3).join())).size;
    });
    expect(colours).toBeGreaterThan(50);
    expect(Math.abs(await page.evaluate(() => window.neveDrive!.car.state.speed))).toBeLessThan(0.3);
  });

  test("driving forward leaves two ruts, a track width apart", async () => {
    await visitor.page.evaluate(() => window.neveDrive!.drive(4, { throttle: 0.6 }));
    const across = await visitor.page.evaluate(ACROSS, await visitor.page.evaluate(BEHIND));
    // A rut is where more than a fifth of the fresh depth is gone; runs of them are counted.
    const low = across.map(({ depth, fresh }) => depth < 0.8 * fresh);
    const starts = low.flatMap((is, j) => (is && !low[j - 1] ? [j] : []));
    expect(starts).toHaveLength(2);
    const middles = starts.map((j) => {
      let end = j;
      while (low[end]) end++;
      return 0.5 * (across[j]!.z + across[end - 1]!.z);
    });
    // The wheels stand 1.56 m apart (body.ts); a texel is 0.05 m, and the walls slide in by some texels each.
    expect(Math.abs(middles[1]! - middles[0]! - 1.56)).toBeLessThan(0.15);
  });

  test("a row of the panel changes the snow and the address", async () => {
    const { page } = visitor;
    await page.getByRole("button", { name: "Snow and car" }).click();
    const row = page.locator(".lil-controller", { hasText: "repose" }).locator("input");
    await row.fill("35");
    await row.press("Enter");
    expect(await page.evaluate(() => window.neveDrive!.field.settings.repose)).toBe(35);
    expect(await page.evaluate(() => location.hash)).toContain("repose=35");
  });

  test("keys that are typed into the panel are the panel's, and come back to the car", async () => {
    const { page } = visitor;
    const row = page.locator(".lil-controller", { hasText: "repose" }).locator("input");
    const asked = () => page.evaluate(() => document.getElementById("figures")!.hidden);
    await row.focus();
    await page.keyboard.press("KeyF");
    await page.locator(".lil-controller", { hasText: "type" }).locator("select").selectOption("packed");
    expect(await page.evaluate(() => document.activeElement === document.body)).toBe(true);
    expect(await page.evaluate(() => location.hash)).toContain("type=packed");
    // A frame has to look at the keys; the one that was typed must not count in it.
    await page.evaluate(() => {
      window.neveDrive!.held = false;
      const look = () => new Promise((next) => requestAnimationFrame(next));
      return look().then(look);
    });
    expect(await asked()).toBe(true);
    await page.keyboard.press("KeyF");
    await page.waitForFunction(() => !document.getElementById("figures")!.hidden);
    await page.keyboard.press("KeyF");
    await page.waitForFunction(() => document.getElementById("figures")!.hidden);
    await page.evaluate(() => (window.neveDrive!.held = true));
  });

  test("H brings the help back, and the speed stands on a plate that is darker than snow", async () => {
    const { page } = visitor;
    await page.keyboard.press("KeyH");
    expect(await page.evaluate(() => document.getElementById("message")!.textContent)).toContain("handbrake");
    const plate = await page.evaluate(
      () => getComputedStyle(document.getElementById("dash")!).backgroundColor,
    );
    const [r, g, b, a] = plate.match(/[\d.]+/g)!.map(Number) as [number, number, number, number];
    // Over white: the contrast of white figures, as WCAG 2 reckons it in linear light, at least 3 for large text.
    const light = [r, g, b].map((c) => ((c * a + 255 * (1 - a)) / 255) ** 2.2);
    expect(1.05 / (0.2126 * light[0]! + 0.7152 * light[1]! + 0.0722 * light[2]! + 0.05)).toBeGreaterThan(3);
  });

  test("another type of snow changes what is seen and keeps the tracks", async () => {
    const { page } = visitor;
    const [before, after, same, changed] = await page.evaluate(async () => {
      const demo = window.neveDrive!;
      const picture = () => {
        demo.stage.render(demo.camera);
        return document.querySelector("canvas")!.toDataURL();
      };
      const rut = async () => {
        const { centre } = demo.car.state.wheels[2]!;
        return (await demo.field.read(centre[0] - 0.5, centre[2], 1, 1))[0]!;
      };
      const [packed, first] = [await rut(), picture()];
      const again = picture();
      demo.settings.type = "ice";
      demo.changed("type");
      const other = picture();
      demo.settings.type = "map";
      demo.changed("type");
      return [packed, await rut(), first === again, first !== other];
    });
    expect(after).toBe(before);
    expect(same).toBe(true);
    expect(changed).toBe(true);
  });

  test("a long pause, as of a hidden tab, moves the car little and the snow by all of it", async () => {
    const place = await visitor.page.evaluate(BEHIND);
    const before = await visitor.page.evaluate(ACROSS, place);
    const way = await visitor.page.evaluate(() => {
      const demo = window.neveDrive!;
      demo.settings.recovery = 30;
      demo.changed("recovery");
      const [x, , z] = demo.car.state.position;
      const speed = Math.abs(demo.car.state.speed);
      demo.advance(30, { steer: 0, throttle: 0, brake: 0, handbrake: 0, reset: false });
      const [x1, , z1] = demo.car.state.position;
      return { moved: Math.hypot(x1 - x, z1 - z), speed };
    });
    expect(way.moved).toBeLessThan(0.1 * way.speed + 0.05);
    const after = await visitor.page.evaluate(ACROSS, place);
    const deepest = (row: typeof before) => Math.max(...row.map(({ depth, fresh }) => fresh - depth));
    // The walls may still slide a little in the one update: a tenth of the depth is left to them.
    expect(deepest(after) / deepest(before)).toBeGreaterThan(0.9 * Math.exp(-1));
    expect(deepest(after) / deepest(before)).toBeLessThan(1.1 * Math.exp(-1));
  });

  test("ice and packed snow are told from powder at a glance: each is darker than what it is beside", async () => {
    const { page } = visitor;
    const [powder, packed, ice] = await page.evaluate(TONES);
    expect(packed!).toBeLessThan(0.93 * powder!);
    expect(ice!).toBeLessThan(0.9 * packed!);
  });

  test("snow that lies on the car hides its paint", async () => {
    const { page } = visitor;
    const [bare, some, much] = [
      await page.evaluate(PAINT, 0),
      await page.evaluate(PAINT, 0.5),
      await page.evaluate(PAINT, 1),
    ];
    expect(bare).toBeGreaterThan(0.02);
    expect(some).toBeLessThan(0.8 * bare);
    expect(much).toBeLessThan(0.9 * some);
  });

  test("snow glitters against a low sun, in about one pixel of a thousand, and not without a sun", async () => {
    const glints = await visitor.page.evaluate(GLINTS, 16.4);
    expect(glints).toBeGreaterThan(0.2);
    expect(glints).toBeLessThan(5);
    expect(await visitor.page.evaluate(GLINTS, 17.5)).toBeLessThan(0.1 * glints);
  });

  test("clods in the air are lit as lumps that lie: in shade against a low sun", async () => {
    const { clod, lump } = await visitor.page.evaluate(CLODS, 16.4);
    // A lump has flat faces, a clod is broken by noise: a tenth is left to them.
    for (const side of [0, 1] as const) {
      expect(clod[side] / lump[side]).toBeGreaterThan(0.9);
      expect(clod[side] / lump[side]).toBeLessThan(1.1);
    }
    expect(clod[1]).toBeLessThan(0.75 * clod[0]);
  });

  test("no pattern sticks to the screen, as it did in the soft edges of shadows", async () => {
    expect(await visitor.page.evaluate(ASIDE)).toBeLessThan(0.002);
  });

  test("the canvas follows the window", async () => {
    const { page } = visitor;
    await page.setViewportSize({ width: 400, height: 160 });
    await page.waitForFunction(() => window.neveDrive!.camera.aspect === 2.5);
    const sizes = await page.evaluate(() => {
      const view = document.querySelector("canvas")!;
      return [view.clientWidth / view.clientHeight, view.width / view.height];
    });
    expect(sizes[0]).toBe(2.5);
    expect(sizes[1]).toBeCloseTo(2.5, 1); // whole pixels
  });

  test("keys drive, change the camera and show the figures", async () => {
    const { page } = visitor;
    await page.evaluate(() => {
      window.neveDrive!.car.reset();
      window.neveDrive!.held = false;
    });
    await page.keyboard.press("KeyF");
    await page.keyboard.down("KeyC");
    await page.waitForFunction(() => window.neveDrive!.cameras.name === "cockpit");
    await page.keyboard.up("KeyC");
    await page.keyboard.down("KeyW");
    await page.waitForFunction(() => window.neveDrive!.car.state.speed > 0.5);
    await page.keyboard.up("KeyW");
    await page.waitForFunction(() => document.getElementById("figures")!.textContent!.includes("draw calls"));
    await page.evaluate(() => (window.neveDrive!.held = true));
  });

  test("a lost context comes back with the picture", async () => {
    const { page } = visitor;
    const drawn = await page.evaluate(async () => {
      const view = document.querySelector("canvas")!;
      const gl = view.getContext("webgl2")!;
      const lose = gl.getExtension("WEBGL_lose_context")!;
      const heard = (name: string) =>
        new Promise((done) => view.addEventListener(name, done, { once: true }));
      const lost = heard("webglcontextlost");
      lose.loseContext();
      await lost;
      window.neveDrive!.drive(0.2, {});
      await new Promise((later) => setTimeout(later, 50)); // the browser restores only after the event is over
      const back = heard("webglcontextrestored");
      lose.restoreContext();
      await back;
      const demo = window.neveDrive!;
      demo.drive(0.2, { throttle: 1 });
      demo.stage.render(demo.camera);
      return { error: gl.getError(), calls: demo.stage.stats.drawCalls };
    });
    expect(drawn.error).toBe(0);
    expect(drawn.calls).toBeGreaterThan(5);
  });

  test("nothing was complained about", () => {
    const told = visitor.errors.filter((line) => !/Context Lost|CONTEXT_LOST/i.test(line));
    expect(told).toEqual([]);
  });
});
