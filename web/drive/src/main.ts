import { WebGLRenderer } from "three";
import { fetchGround } from "./bridge/ground";
import { fetchRecording, type Recording } from "./bridge/recording";
import { Devices, isOurs } from "./car/driver/devices";
import { Demo, SEED } from "./demo";
import { readAddress, writeAddress, type Named } from "./page/address";
import { Loading } from "./page/loading";
import { Loop } from "./page/loop";
import { makePanel } from "./page/panel";
import { loadBest } from "./page/records";
import { element, say } from "./page/words";
import type { Settings } from "./settings";
import { usualDepth } from "./world/snowed_land";

declare global {
  interface Window {
    /** For the console and for tests. */
    neveDrive?: Demo;
  }
}

const HELP = [
  "W A S D or arrows drive, space is the handbrake",
  "C camera, L lights, N sound, R upright, T to the course, P photo, F figures, H this help",
].join("\n");
const HELP_FOR_THUMBS =
  "the left thumb steers, the right one drives and brakes\neverything else is in the panel";

async function begin(): Promise<void> {
  const { settings, recording: run, ground: fall, errors } = readAddress(location.hash);
  const canvas = element("view") as HTMLCanvasElement;
  const loading = new Loading();
  await loading.show(0.05, "Snow clouds gather …");
  const recording = run === null ? null : await got(fetchRecording(run), errors);
  if (recording) take(settings, recording);
  const ground = fall === null ? null : await got(fetchGround(fall), errors);
  if (ground) settings.depth = usualDepth(ground);
  const demo = await Demo.create(makeRenderer(canvas), settings, { recording, ground }, (share, what) =>
    loading.show(share, what),
  );
  loading.done();
  demo.company.course.best = loadBest(SEED);
  demo.held = new URLSearchParams(location.search).has("held"); // for tests: nothing happens but what they do
  window.neveDrive = demo;
  const named = { recording: recording && run, ground: ground && fall };
  const loop = new Loop(demo, new Devices(canvas), canvas);
  makePanel(settings, {
    changed: (name) => demo.changed(name),
    // Not at each change: browsers take a hundred addresses in half a minute, and a slider gives more.
    settled: () => remember(settings, named),
    copyLink: () => void copyLink(settings, named),
    resetCar: () => demo.car.reset(),
    nextCamera: () => say(`${demo.cameras.next()} camera`, 1.5),
    switchLights: () => demo.switchLights(),
    switchSound: () => void loop.switchSound(),
    toCourse: () => demo.toCourse(),
    togglePhoto: () => loop.photo.toggle(),
  });
  addEventListener("hashchange", () => location.reload());
  watchContext(canvas, demo);
  const help = matchMedia("(pointer: coarse)").matches ? HELP_FOR_THUMBS : HELP;
  // Not a key of the devices: it is answered while the page is held, too.
  addEventListener("keydown", (event) => {
    if (isOurs(event) && (event.code === "KeyH" || event.key === "?")) say(help, 8);
  });
  say(errors.length > 0 ? errors.join("\n") : help, errors.length > 0 ? 12 : 6);
  loop.start();
}

/** What the address names; without it the page goes on, and says so. */
async function got<T>(asked: Promise<T>, errors: readonly string[]): Promise<T | null> {
  try {
    return await asked;
  } catch (error) {
    (errors as string[]).push(error instanceof Error ? error.message : String(error));
    return null;
  }
}

/** Make the snow of the page that of a recording: as deep, and as much of it pressed to the side. */
function take(settings: Settings, { snow }: Recording): void {
  settings.depth = Math.min(1.2, Math.max(0.05, Math.round(100 * snow.depth) / 100));
  settings.compaction = Math.min(1, Math.max(0.2, Math.round(100 * snow.compaction) / 100));
}

function makeRenderer(canvas: HTMLCanvasElement): WebGLRenderer {
  try {
    return new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
  } catch {
    throw new Error("This browser has no WebGL 2, which the page draws with.");
  }
}

function remember(settings: Settings, named: Named): void {
  history.replaceState(null, "", `#${writeAddress(settings, named)}`);
}

async function copyLink(settings: Settings, named: Named): Promise<void> {
  remember(settings, named);
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
  element("loading").hidden = true;
  say(error instanceof Error ? error.message : String(error));
  throw error;
});
