/** Presses the trails of others into the snow, some at a time, where the window of the snow comes to them. */
import { STAMPS } from "../snow/footprint";
import type { Stamp } from "../snow/stamps";
import { TILE } from "../world/places";
import type { Terrain } from "../world/terrain_type";
import type { Step } from "../world/trails";

/** How often it is looked for steps that are due [s]. */
const LOOK = 0.4;
/** Tiles farther away than this are forgotten; their tracks have faded or are kept by the snow. */
const FORGET = 3;

interface Tile {
  readonly i: number;
  readonly j: number;
  readonly steps: readonly Step[];
  readonly pressed: boolean[];
}

export class Trails {
  private readonly tiles = new Map<string, Tile>();
  private readonly queue: Step[] = [];
  private waited = LOOK;
  private readonly terrain: Terrain;
  private readonly stepsOn: (i: number, j: number) => Step[];

  constructor(terrain: Terrain, stepsOn: (i: number, j: number) => Step[]) {
    this.terrain = terrain;
    this.stepsOn = stepsOn;
  }

  /**
   * The stamps of this update, one set of passes at most: the nearest steps within `reach` [m] of (x, z) that have
   * not been pressed yet. `depth`: of fresh snow [m].
   */
  due(dt: number, x: number, z: number, reach: number, depth: number): Stamp[] {
    this.waited += dt;
    if (this.waited >= LOOK) {
      this.waited = 0;
      this.look(x, z, reach);
    }
    const stamps: Stamp[] = [];
    while (this.queue.length > 0) {
      const step = this.queue[0]!;
      const ground = this.terrain.height(step.x, step.z);
      const own = step.stamps(ground, depth * this.terrain.cover(step.x, step.z));
      if (stamps.length + own.length > STAMPS) break;
      this.queue.shift();
      stamps.push(...own);
    }
    return stamps;
  }

  private look(x: number, z: number, reach: number): void {
    const [ci, cj] = [Math.floor(x / TILE), Math.floor(z / TILE)];
    for (const [key, { i, j }] of this.tiles)
      if (Math.max(Math.abs(i - ci), Math.abs(j - cj)) > FORGET) this.tiles.delete(key);
    const found: { step: Step; away: number }[] = [];
    for (let i = ci - 1; i <= ci + 1; i++)
      for (let j = cj - 1; j <= cj + 1; j++) {
        const { steps, pressed } = this.tile(i, j);
        steps.forEach((step, n) => {
          const away = Math.max(Math.abs(step.x - x), Math.abs(step.z - z));
          if (pressed[n] || away > reach) return;
          pressed[n] = true;
          found.push({ step, away });
        });
      }
    found.sort((a, b) => a.away - b.away);
    this.queue.push(...found.map(({ step }) => step));
  }

  private tile(i: number, j: number): Tile {
    const key = `${i} ${j}`;
    const known = this.tiles.get(key);
    if (known) return known;
    const tile = { i, j, steps: this.stepsOn(i, j), pressed: [] };
    this.tiles.set(key, tile);
    return tile;
  }
}
