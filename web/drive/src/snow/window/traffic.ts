import type { Vector2 } from "three";
import type { Terrain } from "../../world/terrain_type";
import { coverLattice, onlyFresh } from "./cover";
import type { Passes } from "../gpu/passes";
import { assembled, area, modulo, wrapped, type Rect } from "./rects";
import type { Readback } from "../gpu/readback";
import { COVER_SIDE } from "../gpu/shaders";
import { TileStore } from "./store";
import { TILE, tileKey, tileRect, type Tile, type TileWindow } from "./tiles";

/** How long what was pressed may stay without a copy on the processor [s]. */
const UNSAVED = 2;

/** The snow's clock [s] and the fresh depth of the settings [m]. */
export interface Conditions {
  readonly now: number;
  readonly depth: number;
}

/** The coming and going of tiles between the world, the window on the GPU and the store on the processor. */
export class TileTraffic {
  readonly store = new TileStore();
  private readonly passes: Passes;
  private readonly reads: Readback;
  private readonly window: TileWindow;
  private readonly terrain: Terrain;
  private readonly texel: number;
  private readonly lattices = new Map<string, Float32Array>();

  constructor(passes: Passes, reads: Readback, window: TileWindow, terrain: Terrain, texel: number) {
    this.passes = passes;
    this.reads = reads;
    this.window = window;
    this.terrain = terrain;
    this.texel = texel;
  }

  /**
   * Slide the window to begin at a tile, or make all of it. Returns the tiles that came with tracks, which have to
   * catch up on time; null if the window has to wait for a tile that is still being read back.
   */
  move(tx: number, tz: number, everything: boolean, conditions: Conditions): Tile[] | null {
    const { window } = this;
    if (everything) {
      this.lattices.clear();
      // From so far away that no tile stays.
      window.move(tx + 4 * window.n, tz, conditions.now);
      return this.fill(window.move(tx, tz, conditions.now).entered, conditions);
    }
    if (tx === window.tx && tz === window.tz) return [];
    if (window.entering(tx, tz).some((place) => this.store.expects(tileKey(place)))) return null;
    const { left, entered } = window.move(tx, tz, conditions.now);
    for (const tile of left) {
      if (tile.touched && tile.changedAt > tile.savedAt) this.keep(tile, conditions);
      else this.lattices.delete(tileKey(tile));
    }
    return this.fill(entered, conditions);
  }

  /** Keep a copy of the tile that has gone longest without one, so that a lost context loses little. */
  save(conditions: Conditions): void {
    const stale = ({ touched, changedAt, savedAt }: Tile) =>
      touched && changedAt > savedAt && conditions.now - savedAt > UNSAVED;
    const tile = this.window.tiles.filter(stale).sort((a, b) => a.savedAt - b.savedAt)[0];
    if (tile && !this.store.expects(tileKey(tile))) this.keep(tile, conditions);
  }

  /** Read texels of the window, given in the world, as (h, W) pairs; null if the context is lost before. */
  read(rect: Rect, done: (data: Float32Array | null) => void): void {
    const { passes } = this;
    const n = passes.snow.width;
    const pieces = wrapped(rect, n).map(({ x0, z0, x1, z1 }) => ({ x: x0, y: z0, nx: x1 - x0, ny: z1 - z0 }));
    passes.bind(passes.snow);
    passes.bytes += 24 * area(rect);
    this.reads.read(pieces, (data) => done(data && assembled(rect, n, data)));
  }

  /** Put (h, W) pairs, rows of z, into texels of the window, given in the world. */
  write(rect: Rect, data: Float32Array): void {
    const n = this.passes.snow.width;
    const nx = rect.x1 - rect.x0;
    for (const { x0, z0, x1, z1 } of wrapped(rect, n)) {
      const piece = new Float32Array(2 * (x1 - x0) * (z1 - z0));
      for (let z = z0; z < z1; z++) {
        const from = 2 * (modulo(x0 - rect.x0, n) + nx * modulo(z - rect.z0, n));
        piece.set(data.subarray(from, from + 2 * (x1 - x0)), 2 * (x1 - x0) * (z - z0));
      }
      this.passes.upload(piece, x0, z0, x1 - x0);
    }
  }

  /** Make tiles that entered: fresh ones, and from the store those that had tracks. */
  private fill(tiles: readonly Tile[], conditions: Conditions): Tile[] {
    const { passes, texel } = this;
    const n = passes.snow.width;
    const { x0, z0 } = this.window.rect;
    (passes.uniforms["corner"]!.value as Vector2).set(x0 & (n - 1), z0 & (n - 1));
    (passes.uniforms["origin"]!.value as Vector2).set(x0 * texel, z0 * texel);
    const slots = tiles.map((tile) => wrapped(tileRect(tile), n)[0]!);
    tiles.forEach((tile, k) => this.setCover(tile, slots[k]!));
    passes.cover.needsUpdate = true;
    passes.draw("bed", passes.bed, slots);
    passes.draw("fresh", passes.snow, slots);
    return tiles.filter((tile, k) => this.load(tile, slots[k]!, conditions.depth));
  }

  private setCover(tile: Tile, slot: Rect): void {
    const lattice = coverLattice(this.terrain, tile.tx, tile.tz, this.texel);
    this.lattices.set(tileKey(tile), lattice);
    const side = this.window.n * COVER_SIDE;
    const first = (slot.x0 + side * slot.z0) * (COVER_SIDE / TILE);
    for (let j = 0; j < COVER_SIDE; j++)
      this.passes.cover.image.data!.set(
        lattice.subarray(j * COVER_SIDE, (j + 1) * COVER_SIDE),
        first + side * j,
      );
  }

  /** Bring a tile back from the store, as it was when it was kept. */
  private load(tile: Tile, slot: Rect, depth: number): boolean {
    const stored = this.store.get(tileKey(tile));
    if (!stored) return false;
    const scale = depth / stored.depth;
    this.passes.upload(scale === 1 ? stored.data : stored.data.map((a) => a * scale), slot.x0, slot.z0);
    tile.touched = true;
    tile.settledAt = tile.savedAt = tile.changedAt = stored.time;
    return true;
  }

  /** Read a tile back into the store. What turns out to be fresh snow is not kept. */
  private keep(tile: Tile, { now, depth }: Conditions): void {
    const key = tileKey(tile);
    const time = tile.settledAt;
    const lattice = this.lattices.get(key);
    tile.savedAt = now;
    this.store.expect(key);
    this.read(tileRect(tile), (data) => {
      this.store.arrived(key);
      if (!this.window.at(tile.tx, tile.tz)) this.lattices.delete(key);
      if (!data) return;
      if (lattice && onlyFresh(data, lattice, depth)) this.store.drop(key);
      else this.store.put(key, { data, time, depth });
    });
  }
}
