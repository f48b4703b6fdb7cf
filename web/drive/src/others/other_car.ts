/** Another car, on a track that was recorded, round and round; it waits for who is in its way. Pure. */
import { dot, turn, type Vec } from "../car/geometry";
import { wheelStamp, type CarState } from "../car/state";
import { carAt, type Drive } from "../course/run";
import type { Place, Stamp } from "../snow/stamps";

/** It stops for a car nearer than this [m] that is not behind it. */
const NEAR = 11;
/** How quickly it stops and goes on [1/s]. */
const EASE = 1.5;

export interface Tyres {
  readonly tyreRadius: number; // m
  readonly tyreWidth: number; // m
}

export class OtherCar {
  state: CarState;
  private time: number;
  private pace = 1;
  private readonly drive: Drive;
  private readonly tyres: Tyres;
  private readonly lift: (x: number, z: number) => number;
  private readonly from: (Place | undefined)[] = [];

  /**
   * It begins a share of its track away from the beginning, and stands higher than it drove by `lift` [m] at (x, z).
   */
  constructor(drive: Drive, tyres: Tyres, lift: (x: number, z: number) => number = () => 0, share = 0.3) {
    this.drive = drive;
    this.tyres = tyres;
    this.lift = lift;
    this.time = share * drive.time;
    this.state = this.now();
  }

  /** Go on by dt [s], and return what presses the snow. */
  step(dt: number, player: Vec): Stamp[] {
    const way: Vec = [0, 1, 2].map((k) => player[k]! - this.state.position[k]!) as Vec;
    const ahead = dot(way, turn(this.state.rotation, [1, 0, 0]));
    const wanted = Math.hypot(...way) < NEAR && ahead > -3 ? 0 : 1;
    this.pace += (wanted - this.pace) * -Math.expm1(-EASE * dt);
    const before = this.time;
    this.time = (this.time + this.pace * dt) % this.drive.time;
    if (this.time < before) this.from.length = 0; // from the end of its track to the beginning it flies
    this.state = this.now();
    return this.state.wheels.map((_, k) => {
      const stamp = wheelStamp(this.state, k, this.from[k]);
      this.from[k] = { x: stamp.x, y: stamp.y, z: stamp.z };
      return stamp;
    });
  }

  private now(): CarState {
    const state = carAt(this.drive, this.time, this.tyres.tyreRadius, this.tyres.tyreWidth);
    const more = this.lift(state.position[0], state.position[2]);
    const up = ([x, y, z]: Vec): Vec => [x, y + more, z];
    const wheels = state.wheels.map((wheel) => ({ ...wheel, centre: up(wheel.centre) }));
    return { ...state, position: up(state.position), wheels };
  }
}
