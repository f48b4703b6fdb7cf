/** The company as it is seen: gates, the other car, a ghost, the wheels of a recording. */
import { Group } from "three";
import type { Object3D, Texture, Vector3 } from "three";
import type { Gate } from "../../course/course";
import type { Sight } from "../../others/company";
import { CarView } from "../car/car_view";
import { RollingWheels } from "../car/rolling_wheels";
import type { Atmosphere } from "../sky/atmosphere";
import { Gates } from "./gates";

const BLUE = 0x1f4f8f;
const PALE = 0xbfd8ff;
/** How much snow lies on the other car, 0..1. */
const SNOWED = 0.55;
/** A ghost nearer to the camera than this would fill the picture [m]. */
const TOO_NEAR = 5;

export class CompanyView {
  readonly group = new Group();
  readonly casters: Object3D[];
  private readonly gates: Gates;
  private readonly other: CarView;
  private readonly ghost: CarView;
  private readonly rolling: RollingWheels;

  constructor(
    air: Atmosphere,
    noise: Texture,
    gates: readonly Gate[],
    surface: (x: number, z: number) => number,
  ) {
    this.gates = new Gates(air, gates, surface);
    this.other = new CarView(air, noise, { colour: BLUE, cockpit: false });
    this.ghost = new CarView(air, noise, { colour: PALE, ghost: true, cockpit: false });
    this.rolling = new RollingWheels(air, 2);
    this.group.add(this.gates.mesh, this.other.group, this.ghost.group, this.rolling.mesh);
    this.other.group.visible = this.ghost.group.visible = false;
    this.casters = [...this.other.casters, this.gates.mesh, this.rolling.mesh];
  }

  /** Show what is to be seen from `eye` [m]. */
  update({ other, ghost, next, running, rolling, wheel }: Sight, eye: Vector3): void {
    for (const [view, state] of [
      [this.other, other],
      [this.ghost, ghost],
    ] as const) {
      const [x, y, z] = state?.position ?? [0, 0, 0];
      const hidden = view === this.ghost && Math.hypot(x - eye.x, y - eye.y, z - eye.z) < TOO_NEAR;
      view.group.visible = state !== null && !hidden;
      if (state) view.update(state, SNOWED);
    }
    this.gates.show(next, running);
    if (wheel) this.rolling.update(rolling, wheel.radius, wheel.width);
  }

  /** What paint, glass and metal mirror. */
  mirror(environment: Texture): void {
    for (const view of [this.other, this.ghost]) view.mirror(environment);
  }

  dispose(): void {
    for (const part of [this.gates, this.other, this.ghost, this.rolling]) part.dispose();
  }
}
