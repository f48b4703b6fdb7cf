import { WebGLRenderer } from "three";
import { Devices } from "./car/driver/devices";
import { Demo } from "./demo";
import { readAddress, writeAddress } from "./page/address";
import { Dash } from "./page/dash";
import { Smooth, lines } from "./page/figures";
import { makePanel } from "./page/panel";
import { Sharpness } from "./page/sharpness";
import { element, say } from "./page/words";
import { HANDS_OFF } from "./car/driver/controls";
import type { Settings } from "./settings";

declare global {
  interface Window {
    /** For the console and for tests. */
    neveDrive?: Demo;
  }
}

const HELP = "W A S D or arrows drive, space is the handbrake\nC camera, L lights, R upright, F figures";
const HELP_FOR_THUMBS =
  "the left thumb steers, the right one drives and brakes\neverything else is in the panel";

async function begin(): Promise<void> {
  const { settings, errors } = readAddress(location.hash);
  const canvas = element("view") as HTMLCanvasElement;
  say("Snow is falling …");
  const demo = await Demo.create(makeRenderer(canvas), settings);
  window.neveDrive = demo;
  const devices = new Devices(canvas);
  makePanel(settings, {
    changed: (name) => demo.changed(name),
    // Not at each change: browsers take a hundred addresses in half a minute, and a slider gives more.
    settled: () => remember(settings),
    copyLink: () => void copyLink(settings),
    resetCar: () => demo.car.reset(),
    nextCamera: () => say(`${demo.cameras.next()} camera`, 1.5),
    switchLights: () => demo.switchLights(),
  });
  addEventListener("hashchange", () => location.reload());
  watchContext(canvas, demo);
  const help = matchMedia("(pointer: coarse)").matches ? HELP_FOR_THUMBS : HELP;
  say(errors.length > 0 ? errors.join("\n") : help, errors.length > 0 ? 12 : 6);
  run(demo, devices, canvas);
}

function makeRenderer(canvas: HTMLCanvasElement): WebGLRenderer {
  try {
    return new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
  } catch {
    throw new Error("This browser has no WebGL 2, which the page draws with.");
  }
}

/** Frame after frame. A hidden tab gets none; what the snow missed comes in its next update. */
function run(demo: Demo, devices: Devices, canvas: HTMLCanvasElement): void {
  const sharpness = new Sharpness(window.devicePixelRatio);
  const dash = new Dash();
  const figures = element("figures");
  const mean = new Smooth();
  const fit = () => demo.resize(canvas.clientWidth, canvas.clientHeight, sharpness.ratio);
  addEventListener("resize", fit);
  fit();
  let last = performance.now();
  let told = 0;
  const frame = (now: number): void => {
    requestAnimationFrame(frame);
    const dt = Math.max(0, (now - last) / 1e3);
    last = now;
    if (demo.held) return;
    if (sharpness.take(dt)) fit();
    const { controls, presses } = devices.read(dt);
    if (presses.camera) say(`${demo.cameras.next()} camera`, 1.5);
    if (presses.lights) demo.switchLights();
    if (presses.figures) figures.hidden = !figures.hidden;
    demo.advance(dt, controls, devices.readCamera());
    demo.draw();
    const smooth = mean.take(dt, dt);
    if (now - told < 100) return;
    told = now;
    dash.show(demo.reading());
    if (!figures.hidden) figures.textContent = lines(demo.cost(smooth)).join("\n");
  };
  demo.advance(0, HANDS_OFF);
  requestAnimationFrame(frame);
}

function remember(settings: Settings): void {
  history.replaceState(null, "", `#${writeAddress(settings)}`);
}

async function copyLink(settings: Settings): Promise<void> {
  remember(settings);
  try {
    await navigator.clipboard.writeText(location.href);
    say("The link is in the clipboard.", 3);
  } catch {
    say("The clipboard is closed to this page; the address above holds the settings.", 5);
  }
}

function watchContext(canvas: HTMLCanvasElement, demo: Demo): void {
  canvas.addEventListener("webglcontextlost", () =>
    say("The graphics were lost; waiting for them to come back."),
  );
  canvas.addEventListener("webglcontextrestored", () => {
    demo.stage.restore();
    say("The graphics are back.", 3);
  });
}

begin().catch((error: unknown) => {
  say(error instanceof Error ? error.message : String(error));
  throw error;
});
