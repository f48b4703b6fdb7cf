import { PerspectiveCamera, Vector2 } from "three";
import type { WebGLRenderer } from "three";
import { aim, Cameras } from "./car/driver/cameras";
import type { CameraInput } from "./car/driver/cameras";
import { HANDS_OFF, type Controls } from "./car/driver/controls";
import { Car } from "./car/vehicle";
import { fittedType } from "./bridge/playback";
import type { Snowed } from "./bridge/ground";
import type { Recording } from "./bridge/recording";
import { driveOf } from "./course/run";
import track from "./others/track.json";
import { Company } from "./others/company";
import { COARSE_RINGS } from "./render/ground/snow_surface";
import { Stage } from "./render/stage";
import type { Reading } from "./page/dash";
import type { Cost } from "./page/figures";
import { snowSettings } from "./page/snow_settings";
import type { ChoiceName, QuantityName, Settings } from "./settings";
import { SnowField } from "./snow/field";
import type { Column } from "./snow/law";
import { mixSnow, type SnowType } from "./snow/types";
import { placesOf, TILE, type Places } from "./world/places";
import { outside } from "./world/snowed_land";
import { makeTerrain } from "./world/terrain";
import type { Terrain } from "./world/terrain_type";
import { withType } from "./world/uniform";

/** The world that everybody sees. */
export const SEED = 7;
/** Depth of snow on which the other car drove its track [m]. */
const TRACK_DEPTH = 0.45;
/** How far before the first gate of the course the car is put [m]. */
const RUN_UP = 14;
/** What a frame may last for the car [s]; in a longer one (a hidden tab) it stands still for the rest. */
const LONGEST = 0.1;

/** What Neve has computed and the world takes in; null: nothing. */
export interface Given {
  readonly recording: Recording | null;
  readonly ground: Snowed | null;
}
const NOTHING: Given = { recording: null, ground: null };

/** Car, snow and picture together: what happens in a frame, and in which order. It knows no panel and no keys. */
export class Demo {
  readonly camera = new PerspectiveCamera(55, 1, 0.1, 8000);
  readonly cameras: Cameras;
  readonly settings: Settings;
  readonly terrain: Terrain;
  readonly stage: Stage;
  readonly car: Car;
  readonly company: Company;
  field: SnowField;
  /** Whether the page holds still between calls of `drive` and `draw`: for tests and pictures. */
  held = false;
  private readonly renderer: WebGLRenderer;
  private readonly powder: SnowType | undefined;

  /**
   * Make the world; loads the physics first. `recording`: of a run, to be played beside the car; `ground`: to begin on.
   * `told` hears how far it has come. Errors: Error with a sentence, when the browser lacks something.
   */
  static async create(
    renderer: WebGLRenderer,
    settings: Settings,
    { recording, ground }: Given = NOTHING,
    told: (share: number, what: string) => Promise<void> = async () => undefined,
  ): Promise<Demo> {
    const missing = SnowField.missing(renderer);
    if (missing) throw new Error(missing);
    await told(0.1, "Hills rise …");
    const map = makeTerrain(SEED, ground);
    const terrain = withType(map, () => settings.type);
    let demo: Demo | null = null;
    const snow = (x: number, z: number): Column => {
      if (demo) return demo.field.column(x, z);
      const fresh = settings.depth * terrain.cover(x, z);
      return { h: fresh, W: fresh };
    };
    // Trees stand where the map has them, whatever type of snow is chosen.
    const free = (x: number, z: number) => ground === null || outside(ground, x, z) > 0;
    const standing = { tile: TILE, on: (i: number, j: number) => placesOf(map, i, j, SEED, free) };
    await told(0.25, "The car is built …");
    const powder = recording ? fittedType(recording) : undefined;
    const car = await Car.create({ terrain, snow, settings, standing, ...(powder && { powder }) });
    // The track was driven over the hills: on other ground the other car would fly or dig.
    const driven = ground ? null : driveOf(track);
    const options = { map, terrain, settings, seed: SEED, track: driven, trackDepth: TRACK_DEPTH };
    const company = new Company({ ...options, recording });
    await told(0.45, "Trees grow …");
    demo = new Demo(renderer, settings, terrain, { car, company, powder }, standing.on);
    await told(0.75, "Snow is falling …");
    demo.advance(0, HANDS_OFF);
    demo.stage.prepare(demo.camera);
    return demo;
  }

  private constructor(
    renderer: WebGLRenderer,
    settings: Settings,
    terrain: Terrain,
    { car, company, powder }: { car: Car; company: Company; powder: SnowType | undefined },
    placesOn: (i: number, j: number) => Places,
  ) {
    this.renderer = renderer;
    this.settings = settings;
    this.terrain = terrain;
    this.car = car;
    this.company = company;
    this.powder = powder;
    const low = settings.detail === "low" || (settings.detail === "auto" && drawsByProcessor(renderer));
    const fresh = (x: number, z: number) => terrain.height(x, z) + settings.depth * terrain.cover(x, z);
    const { gates } = company.course;
    let field: SnowField | null = null;
    const surface = (x: number, z: number) =>
      field === null ? fresh(x, z) : terrain.height(x, z) + this.field.column(x, z).h;
    const options = { terrain, settings, placesOn, gates, surface };
    this.stage = new Stage(renderer, { ...options, ...(low && { rings: COARSE_RINGS }) });
    this.cameras = new Cameras(fresh);
    this.field = field = this.makeField();
  }

  /** Let dt [s] pass: car, camera, ground, snow. Nothing is drawn. */
  advance(dt: number, controls: Controls, aimed?: CameraInput): void {
    const { car, company, stage, camera, settings, field } = this;
    car.step(Math.min(dt, LONGEST), controls);
    stage.braking = car.state.gear === "R" ? controls.throttle : controls.brake; // backwards they change places
    aim(camera, this.cameras.update(car.state, Math.min(dt, LONGEST), aimed));
    camera.updateMatrixWorld();
    const aside = company.step(Math.min(dt, LONGEST), car.state, field);
    stage.update(Math.min(dt, LONGEST), car.state, camera, settings, company.sight());
    stage.read(car.state.speed, car.state.revs, car.state.wheels[0]!.steer);
    const [x, , z] = car.state.position;
    field.follow(x, z);
    field.update(dt, car.stamps(), aside);
  }

  /** Move the camera alone; the world stands still. */
  look(dt: number, aimed: CameraInput): void {
    aim(this.camera, this.cameras.update(this.car.state, Math.min(dt, LONGEST), aimed));
    this.camera.updateMatrixWorld();
    this.stage.update(0, this.car.state, this.camera, this.settings);
  }

  /** What the camera sees, as a PNG of a size [pixels]; null if the browser cannot make it. */
  async picture(width: number, height: number): Promise<Blob | null> {
    const { renderer, camera } = this;
    const [size, ratio, aspect] = [renderer.getSize(new Vector2()), renderer.getPixelRatio(), camera.aspect];
    this.resize(width, height, 1);
    this.draw();
    // The browser may clear what was drawn when this task ends: it is taken now.
    const made = new Promise<Blob | null>((done) => renderer.domElement.toBlob(done, "image/png"));
    this.resize(size.x, size.y, ratio);
    camera.aspect = aspect;
    camera.updateProjectionMatrix();
    const blob = await made;
    this.draw();
    return blob;
  }

  /** Put the car before the first gate of the course. */
  toCourse(): void {
    const { x, z, heading } = this.company.course.gates[0]!;
    this.company.course.abandon();
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    this.car.place({ x: x - RUN_UP * c, z: z - RUN_UP * s, heading });
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
    const type = mixSnow(this.terrain.kinds(x, z), this.powder).name;
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
