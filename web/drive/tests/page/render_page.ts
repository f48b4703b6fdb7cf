/** A page with the stage alone; `window.show(view, settings)` draws one picture (tools/shots.mjs calls it). */
import { PerspectiveCamera, WebGLRenderer } from "three";
import { RINGS } from "../../src/render/ground/snow_surface";
import { Stage } from "../../src/render/stage";
import { defaults } from "../../src/settings";
import type { Settings } from "../../src/settings";
import { placesOf } from "../../src/world/places";
import type { Terrain } from "../../src/world/terrain_type";
import { HILLS, paintedTracks, parkedCar } from "./stand_ins";

interface View {
  /** Eye and what it looks at, from the car's place [m]. */
  eye: [number, number, number];
  at: [number, number, number];
  fov?: number;
  /** Seconds that the stage runs before the picture. */
  seconds?: number;
}

const canvas = document.querySelector("canvas")!;
const renderer = new WebGLRenderer({ canvas, antialias: true });
const found = Object.values(
  import.meta.glob<{ makeTerrain(seed: number): Terrain }>("../../src/world/terrain.ts", { eager: true }),
)[0];
const wanted = new URLSearchParams(location.search);
const terrain = found && !wanted.has("hills") ? found.makeTerrain(Number(wanted.get("seed") ?? 1)) : HILLS;
const settings = defaults();
const begin = performance.now();
const stage = new Stage(renderer, {
  terrain,
  settings,
  gates: [],
  surface: (x, z) => terrain.height(x, z),
  placesOn: (i, j) => placesOf(terrain, i, j, 7),
  rings: { ...RINGS, cells: Number(wanted.get("cells") ?? RINGS.cells) },
});
stage.attachSnow(paintedTracks(settings.depth, terrain));
const ready = performance.now() - begin;
const marks = performance.getEntriesByType("measure").map((m) => `${m.name} ${Math.round(m.duration)}`);
const camera = new PerspectiveCamera(50, 1, 0.1, 8000);

function show(view: View, changes: Partial<Settings> = {}): object {
  const [w, h] = [window.innerWidth, window.innerHeight];
  stage.resize(w, h, 1);
  camera.aspect = w / h;
  camera.fov = view.fov ?? 50;
  camera.updateProjectionMatrix();
  const now: Settings = { ...defaults(), ...changes };
  const car = parkedCar(terrain, now.depth, 0.4);
  const [x, y, z] = car.position;
  camera.position.set(x + view.eye[0], y + view.eye[1], z + view.eye[2]);
  camera.position.y = Math.max(camera.position.y, terrain.height(camera.position.x, camera.position.z) + 0.6);
  camera.lookAt(x + view.at[0], y + view.at[1], z + view.at[2]);
  camera.updateMatrixWorld();
  for (let t = 0; t < (view.seconds ?? 1); t += 1 / 30) stage.update(1 / 30, car, camera, now);
  const start = performance.now();
  stage.render(camera);
  renderer.getContext().finish();
  return { ...stage.stats, ms: performance.now() - start, ready, marks };
}

declare global {
  interface Window {
    show: typeof show;
  }
}
window.show = show;
