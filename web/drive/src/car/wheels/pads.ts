/** The floor below each wheel: a plate at the height at which snow bears it, tilted as what is beneath. */
import type { RigidBody, World } from "@dimforge/rapier3d-compat";
import type RAPIER from "@dimforge/rapier3d-compat";
import { PAD_GROUPS } from "../chassis/groups";

const HALF = 1.2; // wide enough that a wheel cannot leave its plate within a step
const HALF_THICKNESS = 0.5;

export class Pads {
  private readonly bodies: RigidBody[];

  constructor(rapier: typeof RAPIER, world: World, count: number) {
    this.bodies = Array.from({ length: count }, () => {
      const body = world.createRigidBody(
        rapier.RigidBodyDesc.kinematicPositionBased().setTranslation(0, -1e3, 0),
      );
      const shape = rapier.ColliderDesc.cuboid(HALF, HALF_THICKNESS, HALF).setCollisionGroups(PAD_GROUPS);
      world.createCollider(shape, body);
      return body;
    });
  }

  /** Put plate `index` so that the middle of its upper side is at `at` and faces along the unit vector `normal`. */
  place(
    index: number,
    at: readonly [number, number, number],
    normal: readonly [number, number, number],
  ): void {
    const body = this.bodies[index]!;
    const [nx, ny, nz] = normal;
    // Rotation that takes (0, 1, 0) to the normal: axis (nz, 0, -nx), half-angle formulas.
    const w = Math.sqrt(0.5 * (1 + ny));
    body.setTranslation(
      { x: at[0] - HALF_THICKNESS * nx, y: at[1] - HALF_THICKNESS * ny, z: at[2] - HALF_THICKNESS * nz },
      false,
    );
    body.setRotation({ x: nz / (2 * w), y: 0, z: -nx / (2 * w), w }, false);
  }
}
