/**
 * The car: a rigid chassis on four ray-cast suspensions (Rapier), with tyres, engine and snow of its own. Rapier's
 * controller finds the contacts and gives the forces of springs and dampers; its friction is switched off, because it
 * knows no spinning wheels, and the forces of `tyre.ts` act in its place. Steps are 1/120 s, whatever the frame rate.
 */
import type { Settings } from "../settings";
import type { Place, Stamp } from "../snow/stamps";
import type { SnowType } from "../snow/types";
import type { Terrain } from "../world/terrain_type";
import { BODY, GRAVITY, suspension, WHEELS } from "./body";
import { Chassis, normalOver, type Strut } from "./chassis/chassis";
import { clean, type Controls } from "./driver/controls";
import { drivenSpeed, share, type Torque } from "./wheels/driveline";
import { meet, type Meeting, type SnowSample, type Surroundings } from "./wheels/footing";
import { Gearbox, steeringLimit } from "./wheels/gearbox";
import { add, cross, dot, inPlane, scale, turn, unit, type Vec } from "./geometry";
import type { Standing } from "./chassis/obstacles";
import { bellyStamp, interpolate, upright, wheelStamp, type CarState } from "./state";
import { roll, type Tyre } from "./wheels/tyre";
import { pushUnderside } from "./chassis/underside";

/** Length of a step [s]. More than MOST_STEPS in one frame are let go: the car then is slower than the clock. */
export const STEP = 1 / 120;
const MOST_STEPS = 24;
/** Inertia of a wheel with its share of the drive train, per square of its radius [kg]. */
const WHEEL_INERTIA = 11;
/** Speed of the steering [rad/s]. */
const STEERING_RATE = 3;
/** Time over which the load of a wheel is averaged before the snow gives way to it [s]. */
const YIELDING = 0.1;
/** Beyond these the state is broken and the car is put back [m/s], [m below the ground]. */
const FASTEST = 120;
const LOST = 4;

export interface CarOptions {
  readonly terrain: Terrain;
  readonly snow: SnowSample;
  /** Read at every step: they may change while the car drives. */
  readonly settings: Pick<
    Settings,
    "mass" | "power" | "tyreWidth" | "tyreRadius" | "stiffness" | "drive" | "compaction"
  >;
  /** Powder other than the usual one, such as one fitted to a run. */
  readonly powder?: SnowType;
  /** What stands in the way; left out, nothing does. */
  readonly standing?: Standing;
  /** Where it begins [m] and its heading [rad]: (cos, sin) in (x, z). */
  readonly start?: { x: number; z: number; heading: number };
}

interface Wheel {
  readonly tyre: Tyre;
  spin: number; // rad
  slip: number; // m/s
  /** Load as the snow feels it, averaged over a short time [N]. */
  carried: number;
  sideForce: number; // N
  strut: Strut;
  meeting: Meeting;
}

export class Car {
  /** As it is to be drawn: between the last two steps. */
  state: CarState;
  private before: CarState;
  private after: CarState;
  private readonly options: CarOptions;
  private readonly chassis: Chassis;
  private readonly wheels: Wheel[];
  private gearbox = new Gearbox();
  private tuned = "";
  private rest = 0;
  private steer = 0;
  private ploughing = 0;
  private enginePower = 0;
  private resetBefore = false;
  private good: { x: number; z: number; heading: number };
  private readonly from: (Place | undefined)[] = [];

  /** A car that stands on the snow; loads the physics library first. */
  static async create(options: CarOptions): Promise<Car> {
    await Chassis.ready();
    return new Car(options);
  }

  private constructor(options: CarOptions) {
    this.options = options;
    this.chassis = new Chassis(options.terrain, STEP, options.standing);
    this.good = options.start ?? { x: 0, z: 0, heading: 0 };
    this.wheels = WHEELS.map((_, i) => this.freshWheel(i));
    this.tune();
    this.put(this.good);
    this.state = this.before = this.after = this.readState();
  }

  /** Let dt [s] pass: whole steps of STEP, the rest waits for the next call; `state` lies between the last two. */
  step(dt: number, controls: Controls): void {
    const wanted = clean(controls);
    if (wanted.reset && !this.resetBefore) this.reset();
    this.resetBefore = wanted.reset;
    this.rest += dt > 0 ? Math.min(dt, MOST_STEPS * STEP) : 0;
    // The little more than nothing makes 1/60 s two steps in spite of rounding.
    for (let n = Math.floor(this.rest / STEP + 1e-6); n > 0; n--) {
      this.rest -= STEP;
      this.before = this.after;
      this.fixedStep(wanted);
      this.after = this.readState();
    }
    this.state = interpolate(this.before, this.after, Math.min(1, Math.max(0, this.rest / STEP)));
  }

  /** Put the car upright where it stands. */
  reset(): void {
    const ahead = turn(this.chassis.rotation, [1, 0, 0]);
    const [x, , z] = this.chassis.position;
    const here = { x, z, heading: Math.atan2(ahead[2], ahead[0]) };
    this.place(Object.values(here).every(Number.isFinite) ? here : this.good);
  }

  /** Stand still at a place on the map [m], with a heading [rad]: (cos, sin) in (x, z). */
  place(at: { x: number; z: number; heading: number }): void {
    this.put(at);
    this.before = this.after = this.state = this.readState();
    this.rest = 0;
  }

  /** What presses the snow now. Each print names the place of the one before it, so call it once for each update. */
  stamps(): Stamp[] {
    const prints: Stamp[] = this.state.wheels.map((_, i) => wheelStamp(this.state, i, this.from[i]));
    if (this.state.ploughing > 0 && upright(this.state)) prints.push(bellyStamp(this.state, this.from[4]));
    for (let i = 0; i <= 4; i++) {
      const print = prints[i];
      this.from[i] = print && { x: print.x, y: print.y, z: print.z };
    }
    return prints;
  }

  /** Free what the physics library holds. */
  dispose(): void {
    this.chassis.dispose();
  }

  private get where(): Surroundings {
    const { terrain, snow, settings, powder } = this.options;
    return { terrain, snow, compaction: settings.compaction, ...(powder && { powder }) };
  }

  private fixedStep(controls: Controls): void {
    const { chassis, options } = this;
    const { mass } = options.settings;
    this.tune();
    const ahead = turn(chassis.rotation, [1, 0, 0]);
    const speed = dot(chassis.velocity, ahead);
    const target = -controls.steer * steeringLimit(speed, BODY.wheelbase);
    const most = STEERING_RATE * STEP;
    this.steer += Math.min(most, Math.max(-most, target - this.steer));

    const torques = this.torques(controls, speed);
    // All forces come from the velocities that the last step left. One wheel after the other, the car would pull to
    // one side; with what the springs have just added, a car that is held on a slope would creep.
    const motion = chassis.motion();
    const forces = chassis.suspend().map((strut, i) => {
      const wheel = this.wheels[i]!;
      wheel.strut = strut;
      wheel.carried += (strut.load - wheel.carried) * (STEP / YIELDING);
      return this.turnWheel(i, torques[i]!, motion);
    });
    for (const [i, force] of forces.entries()) chassis.push(force, this.wheels[i]!.strut.contact);
    const types = this.wheels.map(({ meeting }) => meeting.type);
    this.ploughing = pushUnderside(chassis, this.where, types, mass, STEP);
    const pace = Math.hypot(...chassis.velocity);
    const drag = 0.5 * BODY.airDensity * BODY.dragArea * pace;
    chassis.push(scale(chassis.velocity, -drag), chassis.position);
    for (let i = 0; i < this.wheels.length; i++) this.placePad(i);
    chassis.advance();
    this.check(ahead);
  }

  private torques(controls: Controls, speed: number): Torque[] {
    const { mass, power, drive, tyreRadius: radius } = this.options.settings;
    const rim =
      radius *
      drivenSpeed(
        this.wheels.map(({ tyre }) => tyre.omega),
        drive,
      );
    const demand = this.gearbox.demand(controls, speed, rim, { mass, power: 1e3 * power }, STEP);
    this.enginePower = demand.drive * rim;
    const wheels = this.wheels.map(({ tyre, slip, strut, meeting }) => ({
      omega: tyre.omega,
      slip,
      load: strut.load,
      friction: meeting.type.friction,
    }));
    return share(demand, controls.handbrake, speed, wheels, { mass, radius, drive });
  }

  /** Turn wheel `index` for a step; the force of the ground on it [N]. */
  private turnWheel(index: number, torque: Torque, motion: (at: Vec) => Vec): Vec {
    const { chassis } = this;
    const { mass, tyreRadius: radius } = this.options.settings;
    const wheel = this.wheels[index]!;
    const { strut, meeting, tyre } = wheel;
    const { friction, sideFriction } = meeting.type;
    const normal = meeting.normal;
    const ahead = unit(inPlane(turn(chassis.rotation, this.pointing(index)), normal));
    const right = cross(ahead, normal);
    const velocity = motion(strut.contact);
    const forward = dot(velocity, ahead);
    const load = strut.load;
    const footing = { load, forward, right: dot(velocity, right), friction, sideFriction };
    const { holdLeft, holdRight } = load > 0 ? meeting : { holdLeft: 0, holdRight: 0 };
    const inertia = WHEEL_INERTIA * radius * radius;
    const force = roll(tyre, { ...footing, holdLeft, holdRight, radius, inertia, ...torque }, STEP);
    wheel.spin += tyre.omega * STEP;
    wheel.slip = load > 0 ? force.slip : 0;
    wheel.sideForce = force.right;
    if (load <= 0) return [0, 0, 0];
    // Snow can stop a wheel, not push it back.
    const most = (0.1 * mass * Math.abs(forward)) / STEP;
    const slowed = Math.min(meeting.resistance, most) * Math.tanh(forward / 0.2);
    return add(scale(ahead, force.forward - slowed), scale(right, force.right));
  }

  private pointing(index: number): Vec {
    return WHEELS[index]!.front ? [Math.cos(this.steer), 0, -Math.sin(this.steer)] : [1, 0, 0];
  }

  /** Find what wheel `index` will meet at the end of the step and put its plate there. */
  private placePad(index: number): void {
    const { chassis } = this;
    const wheel = this.wheels[index]!;
    const centre = chassis.wheelCentre(index, wheel.strut.length);
    const [x, , z] = add(centre, scale(chassis.motion()(centre), STEP));
    wheel.meeting = this.meetingAt(index, x, z);
    this.chassis.pads.place(index, [x, wheel.meeting.height, z], wheel.meeting.normal);
  }

  private meetingAt(index: number, x: number, z: number): Meeting {
    const { tyreRadius: radius, tyreWidth: width } = this.options.settings;
    const { chassis } = this;
    const [ax, , az] = unit(inPlane(turn(chassis.rotation, this.pointing(index)), [0, 1, 0]));
    const forward = chassis.velocity[0] * ax + chassis.velocity[2] * az;
    const { slip, carried } = this.wheels[index] ?? this.freshWheel(index);
    const motion = { sense: forward < -0.1 ? -1 : 1, speed: Math.abs(forward), slip, load: carried };
    return meet(this.where, { x, z, ahead: [ax, az], radius, width, ...motion });
  }

  private freshWheel(index: number): Wheel {
    const { x, z } = WHEELS[index]!;
    const { mass, stiffness, tyreRadius: radius, tyreWidth: width } = this.options.settings;
    const carried = (mass * GRAVITY) / 4;
    const still = { ahead: [1, 0] as const, sense: 1, speed: 0, slip: 0, load: carried };
    const meeting = meet(this.where, { x, z, radius, width, ...still });
    const strut: Strut = {
      grounded: false,
      load: 0,
      // As under the car's weight: hanging free it would press a hole before the first ray is cast.
      length: BODY.restLength - suspension(stiffness).sag,
      contact: [x, meeting.height, z],
    };
    return {
      tyre: { omega: 0, along: 0, across: 0 },
      spin: 0,
      slip: 0,
      carried,
      sideForce: 0,
      strut,
      meeting,
    };
  }

  /** Stand still on the snow at a place. */
  private put(place: { x: number; z: number; heading: number }): void {
    const { settings } = this.options;
    const [c, s] = [Math.cos(place.heading), Math.sin(place.heading)];
    this.chassis.put([place.x, 0, place.z], [0, 1, 0], place.heading);
    this.steer = 0;
    this.gearbox = new Gearbox();
    const heights = WHEELS.map(({ x, z }, i) => {
      this.wheels[i] = this.freshWheel(i);
      return this.meetingAt(i, place.x + x * c - z * s, place.z + x * s + z * c).height;
    });
    const mean = heights.reduce((sum, height) => sum + height, 0) / heights.length;
    const normal = normalOver(heights, place.heading);
    const up = scale(normal, settings.tyreRadius + BODY.axle);
    this.chassis.put(add([place.x, mean, place.z], up), normal, place.heading);
    for (let i = 0; i < WHEELS.length; i++) this.placePad(i);
    // Rays find the plates only after a step. It makes the car fall a little: it is put up again.
    this.chassis.advance();
    this.chassis.put(add([place.x, mean, place.z], up), normal, place.heading);
    this.from.length = 0;
  }

  private tune(): void {
    const { mass, stiffness, tyreRadius } = this.options.settings;
    const key = `${mass} ${stiffness} ${tyreRadius}`;
    if (key === this.tuned) return;
    this.tuned = key;
    this.chassis.tune(mass, stiffness, tyreRadius);
  }

  /** Put the car back when its state is broken, and remember where it was well. */
  private check(ahead: Vec): void {
    const { position, rotation, velocity, angular } = this.chassis;
    const sound = [...position, ...rotation, ...velocity, ...angular].every(Number.isFinite);
    const [x, y, z] = position;
    if (!sound || Math.hypot(...velocity) > FASTEST || y < this.options.terrain.height(x, z) - LOST) {
      this.put(this.good);
    } else {
      this.good = { x, z, heading: Math.atan2(ahead[2], ahead[0]) };
      this.chassis.follow(x, z);
    }
  }

  private readState(): CarState {
    const { chassis, gearbox } = this;
    const { tyreRadius: radius, tyreWidth: width, drive } = this.options.settings;
    const velocity = chassis.velocity;
    return {
      position: chassis.position,
      rotation: chassis.rotation,
      velocity,
      angular: chassis.angular,
      speed: dot(velocity, turn(chassis.rotation, [1, 0, 0])),
      wheels: this.wheels.map(({ strut, slip, spin, meeting, sideForce }, i) => ({
        centre: chassis.wheelCentre(i, strut.length),
        steer: WHEELS[i]!.front ? this.steer : 0,
        spin,
        radius,
        width,
        load: strut.load,
        slip,
        sinkage: meeting.sinkage,
        sideForce,
        grounded: strut.grounded,
      })),
      gear: gearbox.name,
      revs: gearbox.revs(
        radius *
          drivenSpeed(
            this.wheels.map(({ tyre }) => tyre.omega),
            drive,
          ),
      ),
      enginePower: this.enginePower,
      ploughing: this.ploughing,
    };
  }
}
