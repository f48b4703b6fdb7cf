import { PerspectiveCamera } from "three";
import type { WebGLRenderer } from "three";
import { aim, Cameras } from "./car/driver/cameras";
import type { CameraInput } from "./car/driver/cameras";
import type { Controls } from "./car/driver/controls";
import { Car } from "./car/vehicle";
import { Stage } from "./render/stage";
import type { Reading } from "./page/dash";
import type { Cost } from "./page/figures";
import { snowSettings } from "./page/snow_settings";
import type { ChoiceName, QuantityName, Settings } from "./settings";
import { SnowField } from "./snow/field";
import type { Column } from "./snow/law";
import { mixSnow } from "./snow/types";
import { placesOf, TILE, type Places } from "./world/places";
import { makeTerrain } from "./world/terrain";
import type { Terrain } from "./world/terrain_type";
import { withType } from "./world/uniform";

/** The world that everybody sees. */
const SEED = 7;
/** What a frame may last for the car [s]; in a longer one (a hidden tab) it stands still for the rest. */
const LONGEST = 0.1;

/** Grid rings for machines without a graphics card: a tenth of the triangles. */
const COARSE_RINGS = { cells: 40, levels: 9, cell: 0.2 };

/** Car, snow and picture together: what happens in a frame, and in which order. It knows no panel and no keys. */
export class Demo {
  readonly camera = new PerspectiveCamera(55, 1, 0.1, 8000);
  readonly cameras: Cameras;
  readonly settings: Settings;
  readonly terrain: Terrain;
  readonly stage: Stage;
  readonly car: Car;
  field: SnowField;
  /** Whether the page holds still between calls of `drive` and `draw`: for tests and pictures. */
  held = false;
  private readonly renderer: WebGLRenderer;

  /** Make the world; loads the physics first. Errors: Error with a sentence, when the browser lacks something. */
  static async create(renderer: WebGLRenderer, settings: Settings): Promise<Demo> {
    const missing = SnowField.missing(renderer);
    if (missing) throw new Error(missing);
    const map = makeTerrain(SEED);
    const terrain = withType(map, () => settings.type);
    let demo: Demo | null = null;
    const snow = (x: number, z: number): Column => {
      if (demo) return demo.field.column(x, z);
      const fresh = settings.depth * terrain.cover(x, z);
      return { h: fresh, W: fresh };
    };
    // Trees stand where the map has them, whatever type of snow is chosen.
    const standing = { tile: TILE, on: (i: number, j: number) => placesOf(map, i, j, SEED) };
    const car = await Car.create({ terrain, snow, settings, standing });
    return (demo = new Demo(renderer, settings, terrain, car, standing.on));
  }

  private constructor(
    renderer: WebGLRenderer,
    settings: Settings,
    terrain: Terrain,
    car: Car,
    placesOn: (i: number, j: number) => Places,
  ) {
    this.renderer = renderer;
    this.settings = settings;
    this.terrain = terrain;
    this.car = car;
    const low = settings.detail === "low" || (settings.detail === "auto" && drawsByProcessor(renderer));
    this.stage = new Stage(renderer, { terrain, settings, placesOn, ...(low && { rings: COARSE_RINGS }) });
    this.cameras = new Cameras((x, z) => terrain.height(x, z) + settings.depth * terrain.cover(x, z));
    this.field = this.makeField();
  }

  /** Let dt [s] pass: car, camera, ground, snow. Nothing is drawn. */
  advance(dt: number, controls: Controls, aimed?: CameraInput): void {
    const { car, stage, camera, settings, field } = this;
    car.step(Math.min(dt, LONGEST), controls);
    stage.braking = car.state.gear === "R" ? controls.throttle : controls.brake; // backwards they change places
    aim(camera, this.cameras.update(car.state, Math.min(dt, LONGEST), aimed));
    camera.updateMatrixWorld();
    stage.update(Math.min(dt, LONGEST), car.state, camera, settings);
    const [x, , z] = car.state.position;
    field.follow(x, z);
    field.update(dt, car.stamps());
  }

  /** Draw what the camera sees. */
  draw(): void {
    this.stage.render(this.camera);
  }

  /** Drive for some seconds in frames of 1/60 s without drawing: for tests, pictures and the console. */
  drive(seconds: number, controls: Partial<Controls>): void {
    const all = { steer: 0, throttle: 0, brake: 0, handbrake: 0, reset: false, ...controls };
    for (let i = Math.round(60 * seconds); i > 0; i--) this.advance(1 / 60, all);
  }

  /** Take over a changed setting. Another resolution begins a new window, without the tracks. */
  changed(name: QuantityName | ChoiceName): void {
    this.field.settings = snowSettings(this.settings);
    if (name === "type") this.stage.repaint();
    if (name !== "resolution") return;
    this.field.dispose();
    this.field = this.makeField();
  }

  /** Fit the picture to its canvas; `ratio` device pixels for each CSS pixel. */
  resize(width: number, height: number, ratio: number): void {
    this.stage.resize(width, height, ratio);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
  }

  /** Switch the headlights, which otherwise follow the daylight. */
  switchLights(): void {
    this.stage.headlights = !(this.stage.headlights ?? this.stage.dark);
  }

  /** What the driver reads. */
  reading(): Reading {
    const { speed, gear, position, wheels } = this.car.state;
    const [x, , z] = position;
    const type = mixSnow(this.terrain.kinds(x, z)).name;
    const depth = this.settings.depth * this.terrain.cover(x, z);
    return { speed, gear, type, depth, sinkage: wheels.map((wheel) => wheel.sinkage) };
  }

  /** What the last frame cost, which took `frame` [s]. */
  cost(frame: number): Cost {
    const { stage, field } = this;
    return {
      frame,
      drawCalls: stage.stats.drawCalls + field.drawCalls,
      triangles: stage.stats.triangles,
      textureBytes: stage.stats.textureBytes + field.textureBytes,
      snowBytes: field.bytesPerUpdate,
      storedTiles: field.storedTiles,
      window: field.size,
    };
  }

  private makeField(): SnowField {
    const { renderer, terrain, settings, stage } = this;
    const resolution = Number(settings.resolution);
    const field = new SnowField(renderer, {
      resolution,
      ground: stage.ground,
      terrain,
      settings: snowSettings(settings),
    });
    stage.attachSnow(field);
    return field;
  }
}

/** Whether WebGL has no graphics card to draw with, as far as the browser tells. */
function drawsByProcessor(renderer: WebGLRenderer): boolean {
  const gl = renderer.getContext();
  const told = gl.getExtension("WEBGL_debug_renderer_info");
  return (
    told !== null &&
    /swiftshader|llvmpipe|software/i.test(String(gl.getParameter(told.UNMASKED_RENDERER_WEBGL)))
  );
}
