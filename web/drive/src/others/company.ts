/** All that shares the world with the car: trails, another car, the course with its ghost, the snow of a run. */
import { Playback, type Both, type Rolling } from "../bridge/playback";
import type { Recording } from "../bridge/recording";
import type { CarState } from "../car/state";
import { Course, layCourse, type Event } from "../course/course";
import { carAt, type Drive } from "../course/run";
import type { Settings } from "../settings";
import type { SnowField } from "../snow/field";
import type { Stamp } from "../snow/stamps";
import type { Terrain } from "../world/terrain_type";
import { trailsOf } from "../world/trails";
import { OtherCar } from "./other_car";
import { Trails } from "./trails";

/** Where a recording begins, seen from the start of the world [m]: beside the car, before it. */
const BRIDGE = { x: 2.2, z: 2.6 };
/** How far the window's edge is left alone [m]. */
const MARGIN = 3;

/** Share of additional snow by which a car stands higher on it. */
const BORNE = 0.45;

/** What is to be seen of the company. */
export interface Sight {
  readonly other: CarState | null;
  readonly ghost: CarState | null;
  readonly next: number;
  readonly running: boolean;
  readonly rolling: readonly Rolling[];
  readonly wheel: { readonly radius: number; readonly width: number } | null;
}

export interface CompanyOptions {
  /** The land as the map has it, on which the course and the trails lie. */
  readonly map: Terrain;
  readonly terrain: Terrain;
  readonly settings: Settings;
  readonly seed: number;
  /** The track of the other car, and the depth of snow on which it was driven [m]. */
  readonly track: Drive | null;
  readonly trackDepth: number;
  readonly recording: Recording | null;
}

export class Company {
  readonly course: Course;
  /** What happened on the course in the last step. */
  event: Event | null = null;
  private readonly options: CompanyOptions;
  private readonly trails: Trails;
  private readonly other: OtherCar | null;
  private readonly playback: Playback | null;

  constructor(options: CompanyOptions) {
    const { map, terrain, settings, seed, track, trackDepth, recording } = options;
    this.options = options;
    this.course = new Course(layCourse(map, seed));
    this.trails = new Trails(terrain, (i, j) => trailsOf(map, i, j, seed));
    const fresh = (x: number, z: number) => settings.depth * terrain.cover(x, z);
    // Deeper snow than on its drive bears the other car higher.
    const lift = (x: number, z: number) => BORNE * (settings.depth - trackDepth) * terrain.cover(x, z);
    this.other = track && new OtherCar(track, settings, lift);
    this.playback = recording && new Playback(recording, BRIDGE, terrain, fresh);
  }

  /** Let dt [s] pass; what presses the snow. */
  step(dt: number, car: CarState, field: SnowField): Stamp[] {
    const { settings } = this.options;
    this.event = this.course.step(dt, car);
    const stamps: Stamp[] = this.playback?.step(dt, field) ?? [];
    if (settings.others === "none") return stamps;
    const [x, , z] = car.position;
    stamps.push(...(this.other?.step(dt, car.position) ?? []));
    return [...stamps, ...this.trails.due(dt, x, z, 0.5 * field.size - MARGIN, settings.depth)];
  }

  /** Name of the recording that is played. */
  get played(): string | undefined {
    return this.playback?.recording.name;
  }

  /** Both wheels of a recording; null without one. */
  both(): Both | null {
    return this.playback?.both() ?? null;
  }

  sight(): Sight {
    const { tyreRadius, tyreWidth, others } = this.options.settings;
    const { best, time, next } = this.course;
    const ghost = best && time !== null ? carAt(best, time, tyreRadius, tyreWidth) : null;
    const other = others === "none" ? null : (this.other?.state ?? null);
    const wheel = this.playback?.recording.wheel ?? null;
    const rolling = this.playback?.wheels() ?? [];
    return { other, ghost, next, running: time !== null, rolling, wheel };
  }
}
