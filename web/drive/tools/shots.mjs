/**
 * Take pictures of the stage in headless Chromium: `node tools/shots.mjs FOLDER [name ...] [--size 960x540]`.
 * The views are below; without names all are taken.
 */
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import process from "node:process";
import { chromium } from "playwright-core";
import { createServer } from "vite";

const say = (...words) => process.stdout.write(`${words.join(" ")}\n`);

const VIEWS = {
  chase: [{ eye: [-7, 2.6, -3.2], at: [2, 0.2, 1] }, {}],
  front: [{ eye: [5.2, 1.1, -2.4], at: [0, 0.1, 0] }, {}],
  noon: [{ eye: [-6, 3, 5], at: [1, 0, 0] }, { hour: 12 }],
  low: [{ eye: [6, 0.9, 5.5], at: [-1, 0.2, -1] }, { hour: 16.3 }],
  dusk: [{ eye: [-7, 2.4, -4.5], at: [4, 0, 2] }, { hour: 17.1 }],
  night: [{ eye: [-7, 3, -3.5], at: [5, 0, 2] }, { hour: 21 }],
  fog: [{ eye: [-7, 2.6, -3.2], at: [2, 0.2, 1] }, { fog: 0.75 }],
  snowfall: [
    { eye: [-7, 2.2, 3.2], at: [2, 0.2, -1] },
    { fog: 0.55, flakes: 1, snowfall: 20, hour: 14 },
  ],
  ruts: [{ eye: [-4.6, 0.6, -2.6], at: [-2, -0.75, -0.6], fov: 40 }, {}],
  bird: [{ eye: [-6, 34, 10], at: [4, 0, 0] }, {}],
  wide: [{ eye: [-30, 14, 30], at: [40, 4, -20], fov: 60 }, {}],
  side: [{ eye: [0.4, 0.7, 5], at: [0, 0, 0], fov: 45 }, { hour: 14 }],
};

const [folder = "shots", ...rest] = process.argv.slice(2);
const size = rest.find((a) => /^\d+x\d+$/.test(a)) ?? "960x540";
const query = rest.find((a) => a.startsWith("?")) ?? "";
const names = rest.filter((a) => a in VIEWS);
const [width, height] = size.split("x").map(Number);

mkdirSync(folder, { recursive: true });
const server = await createServer({ root: process.cwd(), server: { port: 0 }, logLevel: "error" });
await server.listen();
const browser = await chromium.launch({
  executablePath: process.env["NEVE_BROWSER"] ?? "/usr/bin/chromium",
  args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"],
});
const page = await browser.newPage({ viewport: { width, height } });
page.on("console", (m) => m.type() !== "debug" && say(m.type(), m.text()));
page.on("pageerror", (e) => say("error", e.message));
const local = server.resolvedUrls.local[0];
await page.goto(`${local}tests/page/render.html${query}`, { timeout: 120_000 });
await page.waitForFunction(() => "show" in globalThis, null, { timeout: 120_000 });
for (const name of names.length ? names : Object.keys(VIEWS)) {
  const stats = await page.evaluate(([view, settings]) => {
    // The first picture compiles what the second is made of.
    globalThis.show(view, settings);
    return globalThis.show(view, settings);
  }, VIEWS[name]);
  await page.screenshot({ path: join(folder, `${name}.png`), timeout: 120_000 });
  say(name, JSON.stringify(stats));
}
await browser.close();
await server.close();
