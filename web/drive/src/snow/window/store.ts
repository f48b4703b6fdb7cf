/** A tile as it was read back. */
export interface StoredTile {
  /** (h, W) of TILE x TILE texels [m], rows of z. */
  readonly data: Float32Array;
  /** The time to which it belongs, and the fresh depth of the settings then [m]. */
  readonly time: number;
  readonly depth: number;
}

/**
 * Tiles with tracks, by their name. It holds 2048 tiles (64 MB, two to four kilometres of tracks) and then lets go of
 * those that were kept first.
 */
export class TileStore {
  private readonly tiles = new Map<string, StoredTile>();
  private readonly awaited = new Map<string, number>();
  readonly capacity: number;

  constructor(capacity = 2048) {
    this.capacity = capacity;
  }

  get size(): number {
    return this.tiles.size;
  }

  get(key: string): StoredTile | undefined {
    return this.tiles.get(key);
  }

  /** Keep a tile; an older one of the same name gives way, a younger one stays. */
  put(key: string, tile: StoredTile): void {
    const old = this.tiles.get(key);
    if (old && old.time > tile.time) return;
    this.tiles.delete(key);
    this.tiles.set(key, tile);
    if (this.tiles.size > this.capacity) this.tiles.delete(this.tiles.keys().next().value!);
  }

  drop(key: string): void {
    this.tiles.delete(key);
  }

  /** Say that a tile is on its way: whoever needs it waits. Each `expect` is ended by one `arrived`. */
  expect(key: string): void {
    this.awaited.set(key, (this.awaited.get(key) ?? 0) + 1);
  }

  arrived(key: string): void {
    const left = (this.awaited.get(key) ?? 0) - 1;
    if (left > 0) this.awaited.set(key, left);
    else this.awaited.delete(key);
  }

  /** Whether a tile is still on its way. */
  expects(key: string): boolean {
    return this.awaited.has(key);
  }

  /** Whether anything is. */
  get waiting(): boolean {
    return this.awaited.size > 0;
  }
}
