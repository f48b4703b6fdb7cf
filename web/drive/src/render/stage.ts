/** The stage: everything that is seen, put together. */
import { ACESFilmicToneMapping, PCFShadowMap, Scene, Vector2, Vector3 } from "three";
import type { PerspectiveCamera, WebGLRenderer } from "three";
import type { Settings } from "../settings";
import type { GroundSource } from "../world/ground_source";
import type { Places } from "../world/places";
import type { Terrain } from "../world/terrain_type";
import { Atmosphere } from "./sky/atmosphere";
import type { CarPose } from "./car/car_pose";
import { CarView } from "./car/car_view";
import { snowedAfter } from "./car/lying_snow";
import { daylight, overcast } from "./sky/daylight";
import { Flakes } from "./sky/flakes";
import { GroundClipmap } from "./ground/ground_clipmap";
import { Lamps } from "./car/lamps";
import { Lights, SHADOW_BYTES } from "./sky/lights";
import { MIRROR_BYTES, MirroredSky } from "./sky/mirrored_sky";
import { NOISE_BYTES, noiseTexture } from "./ground/noise_texture";
import { Scenery } from "./ground/scenery";
import { Sky } from "./sky/sky";
import { RINGS, SnowSurface } from "./ground/snow_surface";
import type { RingSize, Tracks } from "./ground/snow_surface";
import { Lumps } from "./car/lumps";
import { LumpMotion } from "./car/lump_motion";
import { Spray } from "./car/spray";
import { CompanyView } from "./others/company_view";
import type { Gate } from "../course/course";
import type { Sight } from "../others/company";

export interface StageOptions {
  readonly terrain: Terrain;
  readonly settings: Settings;
  /** What stands on tile (i, j) of the world, as the car meets it. */
  readonly placesOn: (i: number, j: number) => Places;
  readonly gates: readonly Gate[];
  /** Height of the surface of the snow, as well as it is known [m]. */
  readonly surface: (x: number, z: number) => number;
  /** Grid rings of the snow; coarser ones for slow machines. */
  readonly rings?: RingSize;
}

/** Of the last picture: draw calls and triangles of all its passes, bytes of the picture's own textures. */
export interface StageStats {
  drawCalls: number;
  triangles: number;
  textureBytes: number;
}

export class Stage {
  readonly scene = new Scene();
  readonly ground: GroundSource;
  /** Whether the headlights shine; null: by the daylight. */
  headlights: boolean | null = null;
  /** How far the brake is pressed, 0..1: the brake lamps. */
  braking = 0;
  /** Whether the daylight asks for them. */
  dark = false;
  readonly stats: StageStats = { drawCalls: 0, triangles: 0, textureBytes: 0 };
  private readonly renderer: WebGLRenderer;
  private readonly clipmap: GroundClipmap;
  private readonly air: Atmosphere;
  private readonly noise = noiseTexture();
  private readonly snow: SnowSurface;
  private readonly sky: Sky;
  private readonly mirror: MirroredSky;
  private readonly lights: Lights;
  private readonly car: CarView;
  private readonly lamps: Lamps;
  private readonly scenery: Scenery;
  private readonly company: CompanyView;
  private readonly spray: Spray;
  private readonly lying: LumpMotion;
  private readonly lumps: Lumps;
  private readonly flakes: Flakes;
  private readonly focus = new Vector3();
  /** How much snow lies on the car, 0..1. */
  snowed = 0.35;

  constructor(renderer: WebGLRenderer, options: StageOptions) {
    const { terrain, settings, placesOn, gates, surface, rings = RINGS } = options;
    this.renderer = renderer;
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = PCFShadowMap;
    renderer.toneMapping = ACESFilmicToneMapping;
    renderer.info.autoReset = false;
    this.clipmap = new GroundClipmap(terrain);
    this.ground = this.clipmap;
    this.air = new Atmosphere(this.clipmap);
    this.snow = new SnowSurface(this.air, this.noise, rings);
    this.sky = new Sky(this.air, this.noise);
    this.mirror = new MirroredSky(renderer, this.air, this.noise);
    this.car = new CarView(this.air, this.noise);
    this.lamps = new Lamps(this.air);
    this.scenery = new Scenery(this.air, this.noise, placesOn);
    this.company = new CompanyView(this.air, this.noise, gates, surface);
    this.lying = new LumpMotion(surface);
    this.lumps = new Lumps(this.air);
    this.spray = new Spray(this.air, this.noise, surface, (x, z, size) => this.lying.land(x, z, size));
    this.flakes = new Flakes(this.air);
    const fine = [...this.car.casters, ...this.company.casters];
    this.lights = new Lights({ fine, coarse: this.scenery.casters });
    const { snow, sky, lumps, spray, flakes } = this;
    for (const part of [snow, sky, lumps, spray, flakes]) this.scene.add(part.mesh);
    for (const part of [this.lights, this.car, this.company, this.lamps, this.scenery])
      this.scene.add(part.group);
    this.scenery.follow(0, 0, 30);
    this.light(settings, 0);
  }

  /** Direction to the sun, or to the moon at night; x east, y up, z south. */
  get toLight(): Vector3 {
    return this.air.uniforms.lightDirection.value.clone();
  }

  /** Show the tracks of a snow field. */
  attachSnow(field: Tracks): void {
    this.snow.attach(field);
  }

  /** Show that the terrain has other kinds of snow than before. */
  repaint(): void {
    this.clipmap.repaint();
  }

  /** Bring everything to the state of the car, and of what is about it, after dt [s]. */
  update(dt: number, car: CarPose, camera: PerspectiveCamera, settings: Settings, sight?: Sight): void {
    this.focus.set(...car.position);
    this.clipmap.follow(this.focus.x, this.focus.z);
    if (this.scenery.follow(camera.position.x, camera.position.z)) this.lights.refresh();
    const ahead = camera.getWorldDirection(new Vector3());
    this.snow.update(settings.depth, camera.position.x + 5 * ahead.x, camera.position.z + 5 * ahead.z);
    const light = this.light(settings, dt);
    this.dark = light.lamps > 0.5;
    const lamps = this.headlights === null ? light.lamps : Number(this.headlights);
    this.driveOn(dt, car, lamps, light.lamps, this.pixels(camera));
    this.lying.step(dt, car);
    this.lumps.update(dt, this.lying, settings.recovery);
    if (sight) this.company.update(sight, camera.position);
    this.flakes.update(dt, falling(settings), this.pixels(camera));
  }

  /** Show what the driver reads: speed [m/s], engine 0..1, steering of the front wheels [rad]. */
  read(speed: number, revs: number, steer: number): void {
    this.car.read(speed, revs, steer);
  }

  /** Compile what pictures need, so that the first one does not hold up the drive. */
  prepare(camera: PerspectiveCamera): void {
    this.renderer.compile(this.scene, camera);
  }

  render(camera: PerspectiveCamera): void {
    const { info } = this.renderer;
    info.reset();
    this.scenery.look(camera);
    this.snow.look(camera);
    this.car.look(camera.position);
    this.renderer.render(this.scene, camera);
    this.stats.drawCalls = info.render.calls;
    this.stats.triangles = info.render.triangles;
    this.stats.textureBytes = this.clipmap.textureBytes + SHADOW_BYTES + NOISE_BYTES + MIRROR_BYTES;
  }

  /** Size of the canvas in CSS pixels, and device pixels per CSS pixel. */
  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
  }

  /** After a lost and restored context. */
  restore(): void {
    this.clipmap.restore();
    this.lights.refresh();
    this.mirror.restore();
  }

  dispose(): void {
    for (const part of [this.snow, this.sky, this.mirror, this.lights, this.car, this.lamps, this.scenery])
      part.dispose();
    for (const part of [this.company, this.lumps, this.spray, this.flakes, this.clipmap, this.noise])
      part.dispose();
  }

  private driveOn(dt: number, car: CarPose, need: number, dark: number, pixels: number): void {
    this.snowed = snowedAfter(this.snowed, dt, car);
    this.car.update(car, this.snowed);
    this.car.shine(need, Math.max(0.35 * need, this.braking));
    this.lamps.update(this.car, need, this.braking, dark, pixels);
    this.spray.update(dt, car);
  }

  /** Pixels of the canvas that a metre takes one metre before the camera. */
  private pixels(camera: PerspectiveCamera): number {
    const { y } = this.renderer.getDrawingBufferSize(new Vector2());
    return y / (2 * Math.tan((camera.fov * Math.PI) / 360));
  }

  private light(settings: Settings, dt: number) {
    const veil = Math.max(0, settings.fog - 0.45) / 0.55;
    // Thick snow falls from thick clouds.
    const clouds = Math.max(veil, 1.6 * (falling(settings) - 0.5), 0);
    const light = overcast(daylight(settings.hour), clouds);
    this.air.set(light, settings.fog);
    this.lights.update(light, this.focus);
    this.sky.update(light.stars, dt, clouds);
    const mirrored = this.mirror.update(settings.hour, clouds);
    if (mirrored) for (const part of [this.car, this.company]) part.mirror(mirrored);
    this.renderer.toneMappingExposure = settings.exposure;
    return light;
  }
}

/** How thick the falling snow is, 0..1: as it is set to look, or as thick as what falls needs. */
function falling(settings: Settings): number {
  return Math.max(settings.flakes, Math.min(1, settings.snowfall / 60));
}
