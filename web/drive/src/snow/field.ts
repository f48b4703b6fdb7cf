import { Vector4, type IUniform, type Texture, type WebGLRenderer } from "three";
import type { GroundSource } from "../world/ground_source";
import type { Terrain } from "../world/terrain_type";
import { slideRect, stampRect, STAMPS } from "./footprint";
import type { Column } from "./law";
import { Passes } from "./gpu/passes";
import { Patch } from "./gpu/patch";
import { Prints } from "./prints";
import { Readback } from "./gpu/readback";
import { dueTiles, recoverTiles } from "./gpu/recovery";
import { area, common, hull, joined, wrapped, type Rect } from "./window/rects";
import type { SnowSettings } from "./settings";
import { sampling } from "./gpu/shaders";
import type { Stamp } from "./stamps";
import { TILE, tileRect, TileWindow } from "./window/tiles";
import { TileTraffic } from "./window/traffic";

export type { SnowSettings } from "./settings";

export interface SnowOptions {
  /** Texels along a side of the window: a power of two, 128 to 4096. */
  resolution: number;
  /** Size of a texel [m]. */
  texel?: number;
  ground: GroundSource;
  terrain: Terrain;
  settings: SnowSettings;
}

/** Bytes that an update may move at most; what the stamps leave of them goes to recovery. */
const BUDGET = 7.6e6;
/** Steps of sliding in an update: odd, because each goes from one texture to the other. */
const SLIDES = 3;
/**
 * The snow about the car: a window of an endless world as a texture of (depth h, mass W as depth at fresh density),
 * pressed, piled up, sliding and recovering on the GPU.
 */
export class SnowField {
  settings: SnowSettings;
  readonly texel: number;
  readonly resolution: number;
  /** `snowAt`, `snowInside` for shaders, and what they read. */
  readonly glsl: string;
  readonly uniforms: Record<"snowMap" | "snowWindow" | "snowFresh", IUniform>;
  /** Bytes that the last update read and wrote, and its draws. */
  bytesPerUpdate = 0;
  drawCalls = 0;
  private readonly renderer: WebGLRenderer;
  private readonly passes: Passes;
  private readonly reads: Readback;
  private readonly window: TileWindow;
  private readonly traffic: TileTraffic;
  private now = 0;
  private centre = { x: 0, z: 0 };
  private made = false;
  private lost = false;
  private depth: number;
  private patch: Patch | null = null;
  private readonly prints = new Prints();
  private readonly terrain: Terrain;
  private patchAsked = false;

  /** A sentence for the visitor if the browser cannot do this, else null. */
  static missing(renderer: WebGLRenderer): string | null {
    return renderer.extensions.has("EXT_color_buffer_float")
      ? null
      : "This browser cannot draw into floating-point textures (EXT_color_buffer_float), which the snow needs.";
  }

  constructor(renderer: WebGLRenderer, options: SnowOptions) {
    const missing = SnowField.missing(renderer);
    if (missing) throw new Error(missing);
    const { resolution, terrain, settings } = options;
    if (resolution < 2 * TILE || !Number.isInteger(Math.log2(resolution)))
      throw new Error(
        `The resolution of the snow must be a power of two from ${2 * TILE}, not ${resolution}.`,
      );
    this.renderer = renderer;
    this.terrain = terrain;
    this.resolution = resolution;
    this.texel = options.texel ?? 0.05;
    this.settings = settings;
    this.depth = settings.depth;
    this.window = new TileWindow(resolution / TILE);
    this.passes = new Passes(renderer, resolution, this.texel, options.ground);
    this.reads = new Readback(renderer.getContext() as WebGL2RenderingContext);
    this.traffic = new TileTraffic(this.passes, this.reads, this.window, terrain, this.texel);
    this.glsl = sampling(renderer.extensions.has("OES_texture_float_linear"));
    this.uniforms = {
      snowMap: { value: this.passes.snow.texture },
      snowWindow: { value: new Vector4() },
      snowFresh: { value: this.depth },
    };
    renderer.domElement.addEventListener("webglcontextlost", this.onLost);
    renderer.domElement.addEventListener("webglcontextrestored", this.onRestored);
  }

  /** Length of a side of the window [m]. */
  get size(): number {
    return this.resolution * this.texel;
  }

  /** (h, W), toroidal: the texel of a place is its index in the world modulo the resolution. */
  get texture(): Texture {
    return this.passes.snow.texture;
  }

  /** Least corner of the window [m]. */
  get corner(): { x: number; z: number } {
    const { x0, z0 } = this.window.rect;
    return { x: x0 * this.texel, z: z0 * this.texel };
  }

  /** Bytes of all textures of the snow. */
  get textureBytes(): number {
    return this.passes.textureBytes;
  }

  /** Tiles kept on the processor. */
  get storedTiles(): number {
    return this.traffic.store.size;
  }

  /** Put the window about a place [m]; it moves at the next update. */
  follow(x: number, z: number): void {
    this.centre = { x, z };
  }

  /**
   * Let dt seconds pass and press the snow. The ground that shaders see must be right within the window by now. With
   * dt = 0 nothing slides: the snow is pressed and the rims are laid down, and a second time changes nothing.
   * `aside`: stamps that press as well, but about which no snow is read back for `probe` and `column`.
   */
  update(dt: number, stamps: readonly Stamp[], aside: readonly Stamp[] = []): void {
    this.reads.poll();
    if (this.lost) return;
    this.now += dt;
    this.passes.begin();
    this.prepare();
    const { rect } = this.window;
    const here = (stamp: Stamp) => area(common(stampRect(stamp, this.texel), rect)) > 0;
    const [inside, besides] = [stamps.filter(here), aside.filter(here)];
    for (const group of [inside, besides])
      for (let i = 0; i < group.length; i += STAMPS) this.press(group.slice(i, i + STAMPS), dt);
    this.traffic.save({ now: this.now, depth: this.depth });
    this.requestPatch(inside, dt, this.prints.add(inside));
    const due = dueTiles(this.window.tiles, this.settings, this.now);
    if (due.length > 0) recoverTiles(this.passes, due, this.settings, this.now, BUDGET - this.passes.bytes);
    this.passes.end();
    this.bytesPerUpdate = this.passes.bytes;
    this.drawCalls = this.passes.draws;
  }

  /** The snow at a place [m] as last read from about the stamps, some frames ago; null where it is not known. */
  probe(x: number, z: number): Column | null {
    return this.patch?.at(x, z) ?? null;
  }

  /**
   * The snow at a place [m] as it is now, as well as the processor knows: what was last read, or fresh snow where
   * nothing was, pressed by the stamps since. Rims and slides since then are not in it.
   */
  column(x: number, z: number): Column {
    const fresh = this.settings.depth * this.terrain.cover(x, z);
    const known = this.probe(x, z) ?? { h: fresh, W: fresh };
    return this.prints.press(known, x, z, this.terrain.height(x, z), this.settings.compaction);
  }

  /**
   * Read nx x nz texels from the one that holds (x0, z0) [m], rows of z, as (h, W) pairs, recovered up to now. For
   * tests and tools. Errors: when a part lies outside the window.
   */
  async read(x0: number, z0: number, nx: number, nz: number): Promise<Float32Array> {
    while (!this.ready()) await new Promise((later) => setTimeout(later, 4));
    const [x, z] = [x0, z0].map((a) => Math.floor(a / this.texel + 1e-6)) as [number, number];
    const rect = { x0: x, z0: z, x1: x + nx, z1: z + nz };
    if (area(common(rect, this.window.rect)) !== nx * nz)
      throw new Error("only texels of the window can be read");
    this.passes.begin();
    const touched = this.window.tiles.filter((tile) => tile.touched);
    recoverTiles(this.passes, touched, this.settings, this.now);
    const data = await new Promise<Float32Array | null>((done) => {
      this.traffic.read(rect, done);
      this.passes.end();
    });
    if (!data) throw new Error("the WebGL context was lost while the snow was read");
    return data;
  }

  /**
   * Write nx x nz texels from the one that holds (x0, z0) [m], rows of z, as (h, W) pairs: snow that something else
   * has made, such as a recording. False if the window does not hold all of them now.
   */
  write(x0: number, z0: number, nx: number, data: Float32Array): boolean {
    const [x, z] = [x0, z0].map((a) => Math.floor(a / this.texel + 1e-6)) as [number, number];
    const rect = { x0: x, z0: z, x1: x + nx, z1: z + data.length / (2 * nx) };
    if (this.lost || !this.made || area(common(rect, this.window.rect)) !== area(rect)) return false;
    this.passes.begin();
    this.touch(rect);
    this.traffic.write(rect, data);
    this.passes.end();
    return true;
  }

  /**
   * Let the slopes of the window, or of a part of it about a place [m], slide for so many steps, rounded up to even.
   */
  relax(steps: number, part?: { x: number; z: number; reach: number }): void {
    if (this.lost) return;
    this.passes.begin();
    this.prepare();
    const { rect } = this.window;
    const near = (a: number) => Math.round(a / this.texel);
    const inner = part && {
      x0: near(part.x - part.reach),
      z0: near(part.z - part.reach),
      x1: near(part.x + part.reach),
      z1: near(part.z + part.reach),
    };
    const region = inner ? common(inner, rect) : rect;
    const far = Math.ceil(steps / TILE) * TILE;
    for (const tile of this.window.over(region).filter(({ touched }) => touched)) {
      const { x0, z0, x1, z1 } = tileRect(tile);
      this.touch({ x0: x0 - far, z0: z0 - far, x1: x1 + far, z1: z1 + far });
    }
    const { snow, other } = this.passes;
    for (let i = 0; i < steps; i += 2) {
      this.slide(region, snow, other, true);
      this.slide(region, other, snow, true);
    }
    this.passes.end();
  }

  /** Make everything again after the context was lost and came back; the field also notices that itself. */
  restore(): void {
    if (!this.lost) return;
    this.lost = false;
    this.made = false;
  }

  dispose(): void {
    this.reads.abandon();
    this.renderer.domElement.removeEventListener("webglcontextlost", this.onLost);
    this.renderer.domElement.removeEventListener("webglcontextrestored", this.onRestored);
    this.passes.dispose();
  }

  private readonly onLost = () => {
    this.lost = true;
    this.patchAsked = false;
    this.reads.abandon();
  };

  private readonly onRestored = () => this.restore();

  /** Whether the window is where it should be and all its tiles are there; makes it so if it can. */
  private ready(): boolean {
    this.reads.poll();
    if (this.lost) return false;
    this.passes.begin();
    const there = this.prepare();
    this.passes.end();
    return there;
  }

  /** Move the window and follow the settings. False if the window waits for tiles on their way. */
  private prepare(): boolean {
    const { uniforms, stamps } = this.passes;
    const { depth, compaction, repose } = this.settings;
    if (this.made && depth !== this.depth) this.rescale(depth / this.depth);
    this.depth = depth;
    this.uniforms.snowFresh.value = uniforms["depth"]!.value = depth;
    uniforms["compaction"]!.value = compaction;
    uniforms["repose"]!.value = Math.tan((repose * Math.PI) / 180);
    uniforms["count"]!.value = stamps.count;
    return this.move();
  }

  /** Slide the window by whole tiles. A window with a tile that is still being read back waits for it. */
  private move(): boolean {
    const { window, settings, now, texel } = this;
    const { tx, tz } = window.wanted(this.centre.x / texel, this.centre.z / texel);
    const came = this.traffic.move(tx, tz, !this.made, { now, depth: this.depth });
    if (!came) return false;
    this.made = true;
    this.uniforms.snowWindow.value.set(window.rect.x0 * texel, window.rect.z0 * texel, this.size, texel);
    recoverTiles(this.passes, came, settings, now);
    return true;
  }

  private rescale(factor: number): void {
    const { passes, resolution: n } = this;
    const all = [{ x0: 0, z0: 0, x1: n, z1: n }];
    passes.draw("scale", passes.other, all, [[factor, 0]]);
    passes.draw("copy", passes.snow, all, [], passes.other);
    for (const tile of this.window.tiles) if (tile.touched) tile.changedAt = this.now + 1e-9;
  }

  /** Up to STAMPS stamps: what they displace, the pressed snow and the rims, and what slides then. */
  private press(stamps: readonly Stamp[], dt: number): void {
    const { passes, window, texel, resolution: n } = this;
    passes.stamps.set(stamps, window.rect, texel, this.settings.rimShare);
    passes.uniforms["count"]!.value = stamps.length;
    passes.draw("sum", passes.lanes, [{ x0: 0, z0: 0, x1: passes.lanes.width, z1: stamps.length }]);
    passes.draw("lanes", passes.sums, [{ x0: 0, z0: 0, x1: 1, z1: stamps.length }]);
    for (const rect of joined(stamps.map((stamp) => common(slideRect(stamp, texel, dt), window.rect)))) {
      this.touch(rect);
      passes.draw("stamp", passes.other, wrapped(rect, n));
      if (dt <= 0) passes.draw("copy", passes.snow, wrapped(rect, n), [], passes.other);
      else
        for (let i = 0; i < SLIDES; i++) {
          const [from, to] = i % 2 ? [passes.snow, passes.other] : [passes.other, passes.snow];
          this.slide(rect, from, to, i === SLIDES - 1);
        }
    }
  }

  private slide(rect: Rect, from: Passes["snow"], to: Passes["snow"], last: boolean): void {
    const { uniforms } = this.passes;
    const { x0, z0 } = this.window.rect;
    (uniforms["region"]!.value as Vector4).set(rect.x0 - x0, rect.z0 - z0, rect.x1 - x0, rect.z1 - z0);
    uniforms["last"]!.value = last;
    this.passes.draw("slide", to, wrapped(rect, this.resolution), [], from);
  }

  /** Remember that tiles changed. */
  private touch(rect: Rect): void {
    for (const tile of this.window.over(rect)) {
      if (!tile.touched) tile.settledAt = this.now;
      tile.touched = true;
      // Later than a copy that was taken at this very moment.
      tile.changedAt = this.now + 1e-9;
    }
  }

  /** Ask for a patch about the stamps, those of `turn` among them, and where they go, unless one is on its way. */
  private requestPatch(stamps: readonly Stamp[], dt: number, turn: number): void {
    if (this.patchAsked || stamps.length === 0) return;
    const rects = stamps.flatMap((stamp) => {
      const rect = stampRect(stamp, this.texel);
      const { from } = stamp;
      if (!from || dt <= 0) return [rect];
      const ahead = Math.min(0.2 / dt, 3 / Math.max(1e-6, Math.hypot(stamp.x - from.x, stamp.z - from.z)));
      const [dx, dz] = [stamp.x - from.x, stamp.z - from.z].map((d) => Math.round((d * ahead) / this.texel));
      return [rect, { x0: rect.x0 + dx!, z0: rect.z0 + dz!, x1: rect.x1 + dx!, z1: rect.z1 + dz! }];
    });
    const rect = common(rects.reduce(hull), this.window.rect);
    if (area(rect) > 256 * 256) return;
    this.patchAsked = true;
    this.traffic.read(rect, (data) => {
      this.patchAsked = false;
      if (!data) return;
      this.patch = new Patch(rect, data, this.texel);
      this.prints.forget(turn);
    });
  }
}
