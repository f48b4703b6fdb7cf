/** The part of the car that Rapier reckons: a rigid body, four springs with dampers, and what they touch. */
import RAPIER from "@dimforge/rapier3d-compat";
import type { Terrain } from "../../world/terrain_type";
import { BODY, GRAVITY, inertia, suspension, WHEELS } from "../body";
import { add, cross, multiply, scale, turn, unit, yaw, type Quaternion, type Vec } from "../geometry";
import { GroundChunks } from "./ground_chunks";
import { Obstacles, type Standing } from "./obstacles";
import { CHASSIS_GROUPS, RAY_GROUPS } from "./groups";
import { Pads } from "../wheels/pads";

/** What the suspension of a wheel says after its ray was cast. */
export interface Strut {
  readonly grounded: boolean;
  readonly load: number; // N
  readonly length: number; // m, from the upper end to the middle of the wheel
  readonly contact: Vec; // m
}

type Xyz = { x: number; y: number; z: number };
const triple = ({ x, y, z }: Xyz): Vec => [x, y, z];
const xyz = ([x, y, z]: Readonly<Vec>): Xyz => ({ x, y, z });

export class Chassis {
  readonly pads: Pads;
  private readonly ground: GroundChunks;
  private readonly obstacles: Obstacles | null;
  private readonly world: RAPIER.World;
  private readonly body: RAPIER.RigidBody;
  private readonly controller: RAPIER.DynamicRayCastVehicleController;
  private readonly step: number;
  /** Height of the upper ends of the struts over the centre of mass [m]. */
  private mount = 0;

  /** Load the library; before anything is made. */
  static async ready(): Promise<void> {
    await RAPIER.init();
  }

  constructor(terrain: Terrain, step: number, standing?: Standing) {
    this.step = step;
    this.world = new RAPIER.World({ x: 0, y: -GRAVITY, z: 0 });
    this.world.timestep = step;
    // Rapier cuts a step into parts and lets gravity act in each; impulses from outside act before the first. With
    // more than one part a car that is held on a slope would creep uphill by 3/8 g sin(slope) dt.
    this.world.integrationParameters.numSolverIterations = 1;
    this.world.integrationParameters.numInternalPgsIterations = 4;
    this.body = makeBody(this.world);
    this.controller = this.world.createVehicleController(this.body);
    this.controller.indexUpAxis = 1;
    this.controller.setIndexForwardAxis = 0;
    for (const [i, { x, z }] of WHEELS.entries()) {
      this.controller.addWheel(
        { x, y: 0, z },
        { x: 0, y: -1, z: 0 },
        { x: 0, y: 0, z: 1 },
        BODY.restLength,
        0.38,
      );
      this.controller.setWheelMaxSuspensionTravel(i, BODY.travel);
      this.controller.setWheelFrictionSlip(i, 0); // no friction of Rapier's own
      this.controller.setWheelSideFrictionStiffness(i, 0);
    }
    this.pads = new Pads(RAPIER, this.world, WHEELS.length);
    this.ground = new GroundChunks(RAPIER, this.world, terrain);
    this.obstacles = standing ? new Obstacles(RAPIER, this.world, standing) : null;
  }

  /** Take over mass [kg], frequency of the suspension [Hz] and radius of the tyres [m]. */
  tune(mass: number, frequency: number, radius: number): void {
    const { stiffness, damping, sag } = suspension(frequency);
    this.body.setAdditionalMassProperties(
      mass,
      { x: 0, y: 0, z: 0 },
      inertia(mass),
      { x: 0, y: 0, z: 0, w: 1 },
      true,
    );
    this.body.recomputeMassPropertiesFromColliders();
    this.mount = BODY.restLength - sag - BODY.axle;
    for (const [i, { x, z }] of WHEELS.entries()) {
      this.controller.setWheelChassisConnectionPointCs(i, { x, y: this.mount, z });
      this.controller.setWheelRadius(i, radius);
      this.controller.setWheelSuspensionStiffness(i, stiffness);
      this.controller.setWheelSuspensionCompression(i, damping);
      this.controller.setWheelSuspensionRelaxation(i, damping);
      this.controller.setWheelMaxSuspensionForce(i, 6 * mass * GRAVITY);
    }
  }

  /** Stand at a place without motion, upright over a normal, with a heading [rad]. */
  put(position: Vec, normal: Vec, heading: number): void {
    const w = Math.sqrt(0.5 * (1 + normal[1]));
    const tilt: Quaternion = [normal[2] / (2 * w), 0, -normal[0] / (2 * w), w];
    const [x, y, z, real] = multiply(tilt, yaw(-heading));
    this.body.setTranslation(xyz(position), true);
    this.body.setRotation({ x, y, z, w: real }, true);
    this.body.setLinvel({ x: 0, y: 0, z: 0 }, true);
    this.body.setAngvel({ x: 0, y: 0, z: 0 }, true);
    this.follow(position[0], position[2]);
  }

  /** Have the ground and what stands on it about (x, z) [m]. */
  follow(x: number, z: number): void {
    this.ground.follow(x, z);
    this.obstacles?.follow(x, z);
  }

  get position(): Vec {
    return triple(this.body.translation());
  }

  get rotation(): Quaternion {
    const { x, y, z, w } = this.body.rotation();
    return [x, y, z, w];
  }

  get velocity(): Vec {
    return triple(this.body.linvel());
  }

  get angular(): Vec {
    return triple(this.body.angvel());
  }

  /** Velocities of the points of the body as they are now: a function of the place in the world [m/s]. */
  motion(): (at: Vec) => Vec {
    const { velocity, angular } = this;
    const back = scale(this.position, -1);
    return (at) => add(velocity, cross(angular, add(at, back)));
  }

  /** Cast the rays of the wheels; springs and dampers act for one step. */
  suspend(): Strut[] {
    this.controller.updateVehicle(this.step, undefined, RAY_GROUPS);
    return WHEELS.map((_, i) => {
      const grounded = this.controller.wheelIsInContact(i);
      const contact = grounded ? this.controller.wheelContactPoint(i) : null;
      return {
        grounded,
        load: grounded ? (this.controller.wheelSuspensionForce(i) ?? 0) : 0,
        length: this.controller.wheelSuspensionLength(i) ?? BODY.restLength,
        contact: contact ? triple(contact) : this.wheelCentre(i, BODY.restLength),
      };
    });
  }

  /** Middle of wheel `index` [m] for a length of its strut. */
  wheelCentre(index: number, length: number): Vec {
    const { x, z } = WHEELS[index]!;
    return add(this.position, turn(this.rotation, [x, this.mount - length, z]));
  }

  /** Let a force [N] act at a place for one step. */
  push(force: Vec, at: Vec): void {
    this.body.applyImpulseAtPoint(xyz(scale(force, this.step)), xyz(at), true);
  }

  /** Move on by one step. */
  advance(): void {
    this.world.step();
  }

  /** Free what the library holds. */
  dispose(): void {
    this.controller.free();
    this.world.free();
  }
}

function makeBody(world: RAPIER.World): RAPIER.RigidBody {
  const body = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setCanSleep(false).setCcdEnabled(true));
  const { hullHeight, cabin, underside } = BODY;
  const hull = RAPIER.ColliderDesc.cuboid(BODY.length / 2, hullHeight / 2, BODY.width / 2);
  const roof = RAPIER.ColliderDesc.cuboid(cabin.length / 2, cabin.height / 2, cabin.width / 2);
  hull.setTranslation(0, hullHeight / 2 - underside, 0);
  roof.setTranslation(cabin.x, hullHeight - underside + cabin.height / 2, 0);
  for (const shape of [hull, roof]) {
    world.createCollider(shape.setDensity(0).setFriction(0.35).setCollisionGroups(CHASSIS_GROUPS), body);
  }
  return body;
}

/** Upward unit normal of the plane through four heights at the wheels' places, for a car with a heading [rad]. */
export function normalOver(heights: readonly number[], heading: number): Vec {
  const [fl, fr, rl, rr] = heights as [number, number, number, number];
  const along = (fl + fr - rl - rr) / (2 * BODY.wheelbase);
  const across = (fr + rr - fl - rl) / (2 * BODY.track);
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return unit([-(along * c - across * s), 1, -(along * s + across * c)]);
}
