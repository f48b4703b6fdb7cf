/** The stage: everything that is seen, put together. */
import { PerspectiveCamera, Scene, Vector3 } from "three";
import type { WebGLRenderer } from "three";
import { ACESFilmicToneMapping, PCFShadowMap } from "three";
import type { CarPose } from "./car_pose";
import type { Settings } from "../settings";
import type { GroundSource } from "../world/ground_source";
import type { Terrain } from "../world/terrain_type";
import { Atmosphere } from "./atmosphere";
import { daylight } from "./daylight";
import { GroundClipmap } from "./ground_clipmap";
import { Lights, SHADOW_BYTES } from "./lights";
import { noiseTexture } from "./noise_texture";
import { Sky } from "./sky";
import { RINGS, SnowSurface } from "./snow_surface";
import type { RingSize, Tracks } from "./snow_surface";

export interface StageOptions {
  readonly terrain: Terrain;
  readonly settings: Settings;
  /** Grid rings of the snow; coarser ones for slow machines. */
  readonly rings?: RingSize;
}

export interface StageStats {
  drawCalls: number;
  triangles: number;
  textureBytes: number;
}

export class Stage {
  readonly scene = new Scene();
  readonly ground: GroundSource;
  readonly stats: StageStats = { drawCalls: 0, triangles: 0, textureBytes: 0 };
  private readonly renderer: WebGLRenderer;
  private readonly clipmap: GroundClipmap;
  private readonly air: Atmosphere;
  private readonly noise = noiseTexture();
  private readonly snow: SnowSurface;
  private readonly sky: Sky;
  private readonly lights = new Lights();
  private readonly focus = new Vector3();

  constructor(renderer: WebGLRenderer, { terrain, settings, rings = RINGS }: StageOptions) {
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
    this.scene.add(this.snow.mesh, this.sky.mesh, this.lights.group);
    this.light(settings, 0);
  }

  /** Show the tracks of a snow field. */
  attachSnow(field: Tracks): void {
    this.snow.attach(field);
  }

  /** Bring everything to the state of the car after dt [s]. */
  update(dt: number, car: CarPose, camera: PerspectiveCamera, settings: Settings): void {
    this.focus.set(...car.position);
    this.clipmap.follow(this.focus.x, this.focus.z);
    const ahead = camera.getWorldDirection(new Vector3());
    this.snow.update(settings.depth, camera.position.x + 5 * ahead.x, camera.position.z + 5 * ahead.z);
    this.light(settings, dt);
  }

  render(camera: PerspectiveCamera): void {
    const { info } = this.renderer;
    info.reset();
    this.renderer.render(this.scene, camera);
    this.stats.drawCalls = info.render.calls;
    this.stats.triangles = info.render.triangles;
    this.stats.textureBytes = this.clipmap.textureBytes + SHADOW_BYTES + (4 / 3) * 4 * 256 ** 2;
  }

  /** Size of the canvas in CSS pixels, and device pixels per CSS pixel. */
  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
  }

  /** After a lost and restored context. */
  restore(): void {
    this.clipmap.restore();
    this.lights.restore();
  }

  dispose(): void {
    this.snow.dispose();
    this.sky.dispose();
    this.lights.dispose();
    this.clipmap.dispose();
    this.noise.dispose();
  }

  private light(settings: Settings, dt: number): void {
    const light = daylight(settings.hour);
    this.air.set(light, settings.fog);
    this.lights.update(light, this.focus);
    this.sky.update(light.stars, dt, Math.max(0, settings.fog - 0.45) / 0.55);
    this.renderer.toneMappingExposure = settings.exposure;
  }
}
