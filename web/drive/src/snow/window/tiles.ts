import { modulo, type Rect } from "./rects";

/** Texels along a side of a tile: the window slides by whole tiles. */
export const TILE = 64;

/** A tile of the world inside the window. Times are seconds of the snow's own clock. */
export interface Tile {
  /** Place in the world, in tiles. */
  readonly tx: number;
  readonly tz: number;
  /** Whether it may hold anything but fresh snow. */
  touched: boolean;
  /** Until when recovery and snowfall were reckoned. */
  settledAt: number;
  /** When something last pressed it, and when it was last read back for keeping. */
  changedAt: number;
  savedAt: number;
}

/** The name of a tile in the store. */
export function tileKey({ tx, tz }: { tx: number; tz: number }): string {
  return `${tx},${tz}`;
}

/** The texels of a tile, in the world. */
export function tileRect({ tx, tz }: { tx: number; tz: number }): Rect {
  return { x0: tx * TILE, z0: tz * TILE, x1: (tx + 1) * TILE, z1: (tz + 1) * TILE };
}

function untouched(tx: number, tz: number, now: number): Tile {
  return { tx, tz, touched: false, settledAt: now, changedAt: -Infinity, savedAt: -Infinity };
}

/**
 * The window: n x n tiles of an endless world. A tile keeps its slot (tile index modulo n) for as long as it is in the
 * window, so that sliding moves no texels: only tiles that enter are written.
 */
export class TileWindow {
  /** Least tile of the window. */
  tx = 0;
  tz = 0;
  readonly n: number;
  private slots: Tile[];

  constructor(n: number) {
    this.n = n;
    this.slots = [];
    for (let tz = 0; tz < n; tz++) for (let tx = 0; tx < n; tx++) this.slots.push(untouched(tx, tz, 0));
  }

  /** All tiles of the window. */
  get tiles(): readonly Tile[] {
    return this.slots;
  }

  /** The texels of the window, in the world. */
  get rect(): Rect {
    const [x0, z0] = [this.tx * TILE, this.tz * TILE];
    return { x0, z0, x1: x0 + this.n * TILE, z1: z0 + this.n * TILE };
  }

  /** The tile at a place of the world, or undefined outside the window. */
  at(tx: number, tz: number): Tile | undefined {
    const tile = this.slots[this.slot(tx, tz)]!;
    return tile.tx === tx && tile.tz === tz ? tile : undefined;
  }

  /** The tiles that a rectangle of the world touches. */
  over(rect: Rect): Tile[] {
    return this.slots.filter(
      ({ tx, tz }) =>
        tx * TILE < rect.x1 && (tx + 1) * TILE > rect.x0 && tz * TILE < rect.z1 && (tz + 1) * TILE > rect.z0,
    );
  }

  /**
   * Where the window ought to begin to have a texel of the world (not rounded) near its middle. It stays where it is
   * while the middle is off by less than a tile, so that driving along a seam does not slide it to and fro.
   */
  wanted(x: number, z: number): { tx: number; tz: number } {
    const place = (texel: number, now: number) => {
      const ideal = texel / TILE - this.n / 2;
      return Math.abs(ideal - now) < 1 ? now : Math.round(ideal);
    };
    return { tx: place(x, this.tx), tz: place(z, this.tz) };
  }

  /** The tiles that would enter if the window began at (tx, tz). */
  entering(tx: number, tz: number): { tx: number; tz: number }[] {
    const places = [];
    for (let j = tz; j < tz + this.n; j++)
      for (let i = tx; i < tx + this.n; i++) if (!this.at(i, j)) places.push({ tx: i, tz: j });
    return places;
  }

  /** Slide the window. The tiles that entered begin untouched. */
  move(tx: number, tz: number, now: number): { left: Tile[]; entered: Tile[] } {
    const entered = this.entering(tx, tz).map((place) => untouched(place.tx, place.tz, now));
    const left = entered.map((tile) => this.slots[this.slot(tile.tx, tile.tz)]!);
    for (const tile of entered) this.slots[this.slot(tile.tx, tile.tz)] = tile;
    [this.tx, this.tz] = [tx, tz];
    return { left, entered };
  }

  private slot(tx: number, tz: number): number {
    return modulo(tx, this.n) + this.n * modulo(tz, this.n);
  }
}
