/** The bare ground for the chassis: squares of the terrain's lattice about the car, made and dropped as it moves. */
import type RAPIER from "@dimforge/rapier3d-compat";
import type { Collider, World } from "@dimforge/rapier3d-compat";
import { SPACING } from "../../world/terrain";
import type { Terrain } from "../../world/terrain_type";
import { GROUND_GROUPS } from "./groups";

const CELLS = 32;
/** Side of a square [m]. */
export const CHUNK = CELLS * SPACING;

export class GroundChunks {
  private readonly chunks = new Map<string, Collider>();
  private readonly rapier: typeof RAPIER;
  private readonly world: World;
  private readonly terrain: Terrain;
  private middle = "";

  constructor(rapier: typeof RAPIER, world: World, terrain: Terrain) {
    this.rapier = rapier;
    this.world = world;
    this.terrain = terrain;
  }

  /** Have the square of (x, z) and its eight neighbours, and no others. */
  follow(x: number, z: number): void {
    const [i, j] = [Math.floor(x / CHUNK), Math.floor(z / CHUNK)];
    if (`${i} ${j}` === this.middle) return;
    this.middle = `${i} ${j}`;
    const wanted = new Map<string, [number, number]>();
    for (let di = -1; di <= 1; di++) {
      for (let dj = -1; dj <= 1; dj++) wanted.set(`${i + di} ${j + dj}`, [i + di, j + dj]);
    }
    for (const [key, collider] of this.chunks) {
      if (wanted.has(key)) continue;
      this.world.removeCollider(collider, false);
      this.chunks.delete(key);
    }
    for (const [key, place] of wanted) if (!this.chunks.has(key)) this.chunks.set(key, this.make(...place));
  }

  private make(i: number, j: number): Collider {
    const heights = new Float32Array((CELLS + 1) * (CELLS + 1));
    const [x0, z0] = [i * CHUNK, j * CHUNK];
    // Rapier's matrix of heights is stored by columns: columns follow x, rows follow z.
    for (let column = 0; column <= CELLS; column++) {
      for (let row = 0; row <= CELLS; row++) {
        heights[column * (CELLS + 1) + row] = this.terrain.height(x0 + column * SPACING, z0 + row * SPACING);
      }
    }
    const shape = this.rapier.ColliderDesc.heightfield(CELLS, CELLS, heights, { x: CHUNK, y: 1, z: CHUNK })
      .setTranslation(x0 + CHUNK / 2, 0, z0 + CHUNK / 2)
      .setFriction(0.4)
      .setCollisionGroups(GROUND_GROUPS);
    return this.world.createCollider(shape);
  }
}
