/**
 * The bridge between both methods: the snow of a run, column for column in the texture of the game's snow, and beside it
 * the same wheel under the same load by the game's law.
 */
import type { Column } from "../snow/law";
import { wheelSinkage } from "../snow/law";
import type { Place, WheelStamp } from "../snow/stamps";
import { SNOW_TYPES, type SnowType } from "../snow/types";
import type { Terrain } from "../world/terrain_type";
import { smoothstep } from "../world/noise";
import type { Recording } from "./recording";

/** How long the end of the recording is shown before it begins again [s]. */
export const PAUSE = 2;
/** Distance of the two tracks [m], and width of the border over which the recording passes into the snow about [m]. */
export const APART = 1.5;
const BORDER = 0.16;

/** A wheel that rolls along x. */
export interface Rolling {
  readonly centre: readonly [number, number, number]; // m
  readonly spin: number; // rad
}

/** Both at this moment. */
export interface Both {
  readonly load: number; // N
  readonly recorded: number; // m, sinkage in the run
  readonly game: number; // m, sinkage by the law
}

/** What takes the recorded columns: a snow field. */
export interface Canvas {
  readonly texel: number;
  write(x0: number, z0: number, nx: number, data: Float32Array): boolean;
}

/** The snow whose numbers were fitted to the run. */
export function fittedType({ snow }: Recording): SnowType {
  const { strain, pressure, density } = snow;
  return { ...SNOW_TYPES.powder, name: "fitted", strain, pressure, density };
}

export class Playback {
  readonly recording: Recording;
  /** Time of the recording [s]; beyond its end it stands still for PAUSE. */
  time: number;
  private readonly start: { x: number; z: number };
  private readonly terrain: Terrain;
  private readonly fresh: (x: number, z: number) => number;
  private readonly type: SnowType;
  private before: Place | undefined;
  private clean = false;

  /** The axle of the recorded wheel begins at `start` [m] and rolls along x; `fresh`: depth of fresh snow at (x, z) [m]. */
  constructor(
    recording: Recording,
    start: { x: number; z: number },
    terrain: Terrain,
    fresh: (x: number, z: number) => number,
  ) {
    this.recording = recording;
    this.start = start;
    this.terrain = terrain;
    this.fresh = fresh;
    this.type = fittedType(recording);
    this.time = recording.times[0]!;
  }

  /** Let dt [s] pass and put the recorded columns into the snow; what the game's wheel presses there. */
  step(dt: number, canvas: Canvas): WheelStamp[] {
    const { times } = this.recording;
    const last = times[times.length - 1]!;
    this.time += dt;
    if (this.time > last + PAUSE) {
      this.time = times[0]!;
      this.clean = false;
    }
    this.clean ||= this.wipe(canvas);
    const now = this.now();
    this.paint(canvas, 0, (x, z) => this.column(now, x, z));
    return this.time <= last ? [this.stamp()] : [];
  }

  /** The recorded wheel and the game's. */
  wheels(): [Rolling, Rolling] {
    const { axle, spin } = this.now();
    const x = this.start.x + axle[0];
    const z = this.start.z + axle[1];
    const high = this.terrain.height(x, z) + axle[2] - this.groundAt(axle[0], axle[1]);
    const { x: gx, y, z: gz } = this.stamp();
    return [
      { centre: [x, high, z], spin },
      { centre: [gx, y, gz], spin },
    ];
  }

  /** Load and sinkage of both wheels. */
  both(): Both {
    const { axle, load } = this.now();
    const first = this.recording.moments[0]!.depth;
    const fresh = this.sample(first, axle[0], axle[1]);
    const bottom = axle[2] - this.recording.wheel.radius - this.groundAt(axle[0], axle[1]);
    const game = this.gameSinkage(load, { h: fresh, W: fresh });
    return { load, recorded: Math.max(0, fresh - bottom), game };
  }

  private gameSinkage(load: number, column: Column): number {
    const { wheel, snow } = this.recording;
    return wheelSinkage({ ...wheel, load }, column, this.type, snow.compaction);
  }

  /** Where the game's wheel is: as far as the recorded one, APART to its right. */
  private stamp(): WheelStamp {
    const { axle, load } = this.now();
    const { radius, width } = this.recording.wheel;
    const [x, z] = [this.start.x + axle[0], this.start.z + axle[1] + APART];
    const h = this.fresh(x, z);
    const y = this.terrain.height(x, z) + h - this.gameSinkage(load, { h, W: h }) + radius;
    const from = this.before;
    this.before = { x, y, z };
    const went = from && x >= from.x && x - from.x < 1 ? { from } : {};
    return { shape: "wheel", x, y, z, heading: 0, radius, width, slip: 0, ...went };
  }

  /** Fresh snow on the game's track; false while the window does not hold it. */
  private wipe(canvas: Canvas): boolean {
    return this.paint(canvas, APART, (x, z) => {
      const h = this.fresh(this.start.x + x, this.start.z + z + APART);
      return { h, W: h };
    });
  }

  private paint(canvas: Canvas, aside: number, column: (x: number, z: number) => Column): boolean {
    const { nx, ny, cell, along, across } = this.recording.patch;
    const { texel } = canvas;
    const least = (a: number) => Math.ceil(a / texel - 1e-6);
    const [x0, z0] = [least(this.start.x + along), least(this.start.z + across + aside)];
    const [wide, deep] = [nx, ny].map((n) => Math.floor((n * cell) / texel) - 1) as [number, number];
    const data = new Float32Array(2 * wide * deep);
    for (let j = 0; j < deep; j++)
      for (let i = 0; i < wide; i++) {
        const x = (x0 + i + 0.5) * texel - this.start.x;
        const z = (z0 + j + 0.5) * texel - this.start.z - aside;
        const { h, W } = column(x, z);
        data.set([h, W], 2 * (i + wide * j));
      }
    return canvas.write(x0 * texel, z0 * texel, wide, data);
  }

  /** The recorded column at a place of the track [m]; it passes into fresh snow at the border of the patch. */
  private column({ moment, next, t }: ReturnType<Playback["now"]>, x: number, z: number): Column {
    const { nx, ny, cell, along, across } = this.recording.patch;
    const [h, W] = (["depth", "mass"] as const).map((name) => {
      const a = this.sample(moment[name], x, z);
      return a + (this.sample(next[name], x, z) - a) * t;
    }) as [number, number];
    const edge = Math.min(x - along, along + nx * cell - x, z - across, across + ny * cell - z);
    const share = smoothstep(0, BORDER, edge - cell);
    const fresh = this.fresh(this.start.x + x, this.start.z + z);
    return { h: fresh + (h - fresh) * share, W: fresh + (W - fresh) * share };
  }

  private groundAt(x: number, z: number): number {
    return this.sample(this.recording.ground, x, z);
  }

  /** Numbers of cells at a place of the track, straight between their middles. */
  private sample(values: Float32Array, x: number, z: number): number {
    const { nx, ny, cell, along, across } = this.recording.patch;
    const u = Math.min(nx - 1, Math.max(0, (x - along) / cell - 0.5));
    const v = Math.min(ny - 1, Math.max(0, (z - across) / cell - 0.5));
    const [i, j] = [Math.min(nx - 2, Math.floor(u)), Math.min(ny - 2, Math.floor(v))];
    const at = (a: number, b: number) => values[(i + a) * ny + j + b]!;
    const [s, t] = [u - i, v - j];
    return (at(0, 0) * (1 - t) + at(0, 1) * t) * (1 - s) + (at(1, 0) * (1 - t) + at(1, 1) * t) * s;
  }

  /** The moments about the time, and the wheel between them. */
  private now() {
    const { times, moments, path, spin, force } = this.recording;
    let k = 0;
    while (k < times.length - 2 && times[k + 1]! <= this.time) k++;
    const t = Math.min(1, Math.max(0, (this.time - times[k]!) / (times[k + 1]! - times[k]!)));
    const blend = (a: number, b: number) => a + (b - a) * t;
    const [a, b] = [path[k]!, path[k + 1]!];
    const axle = [0, 1, 2].map((i) => blend(a[i]!, b[i]!)) as [number, number, number];
    return {
      moment: moments[k]!,
      next: moments[k + 1]!,
      t,
      axle,
      spin: blend(spin[k]!, spin[k + 1]!),
      load: Math.max(0, force[k + 1]!),
    };
  }
}
