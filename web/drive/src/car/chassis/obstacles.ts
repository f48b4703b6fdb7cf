/** What stops a car: trees and rocks as fixed bodies, for the tiles of the world that the car can reach soon. */
import type RAPIER from "@dimforge/rapier3d-compat";
import type { Collider, ColliderDesc, World } from "@dimforge/rapier3d-compat";
import type { Place, Places } from "../../world/places";
import { GROUND_GROUPS } from "./groups";

/** What stands on tile (i, j) of the world, whose side is `tile` [m]. */
export interface Standing {
  readonly tile: number;
  readonly on: (i: number, j: number) => Pick<Places, "trees" | "rocks">;
}

/** How far ahead obstacles are made [m]: more than a second at the highest speed. */
const REACH = 48;
/** Radius of a trunk at bumper height and of a rock, as shares of the tree's height and the rock's width. */
const TRUNK = 0.02;
const ROCK = 0.42;

export class Obstacles {
  private readonly tiles = new Map<string, Collider[]>();
  private readonly rapier: typeof RAPIER;
  private readonly world: World;
  private readonly standing: Standing;

  constructor(rapier: typeof RAPIER, world: World, standing: Standing) {
    this.rapier = rapier;
    this.world = world;
    this.standing = standing;
  }

  /** Have the tiles about (x, z) [m], and no others. */
  follow(x: number, z: number): void {
    const { tile } = this.standing;
    const wanted = new Map<string, [number, number]>();
    for (const i of spanned(x, tile)) for (const j of spanned(z, tile)) wanted.set(`${i} ${j}`, [i, j]);
    for (const [key, bodies] of this.tiles) {
      if (wanted.has(key)) continue;
      for (const body of bodies) this.world.removeCollider(body, false);
      this.tiles.delete(key);
    }
    for (const [key, [i, j]] of wanted) if (!this.tiles.has(key)) this.tiles.set(key, this.make(i, j));
  }

  private make(i: number, j: number): Collider[] {
    const { trees, rocks } = this.standing.on(i, j);
    return [...trees.map((place) => this.trunk(place)), ...rocks.map((place) => this.rock(place))];
  }

  private trunk({ x, y, z, size }: Place): Collider {
    const half = 1.5;
    return this.add(this.rapier.ColliderDesc.cylinder(half, TRUNK * size).setTranslation(x, y + half, z));
  }

  private rock({ x, y, z, size }: Place): Collider {
    return this.add(this.rapier.ColliderDesc.ball(ROCK * size).setTranslation(x, y, z));
  }

  private add(shape: ColliderDesc): Collider {
    return this.world.createCollider(
      shape.setFriction(0.5).setRestitution(0.1).setCollisionGroups(GROUND_GROUPS),
    );
  }
}

/** Numbers of the tiles within REACH of a coordinate. */
function spanned(x: number, tile: number): number[] {
  const [first, last] = [Math.floor((x - REACH) / tile), Math.floor((x + REACH) / tile)];
  return Array.from({ length: last - first + 1 }, (_, k) => first + k);
}
