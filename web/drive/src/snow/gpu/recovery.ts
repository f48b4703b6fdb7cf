import { passing } from "../law";
import type { Passes } from "./passes";
import { wrapped, type Rect } from "../window/rects";
import type { SnowSettings } from "../settings";
import { TILE, tileRect, type Tile } from "../window/tiles";

/** Bytes to recover a tile: snow and bed are read, the other texture is written and copied back. */
const RECOVER_BYTES = TILE * TILE * 40;
/** A tile is recovered when that would move its tracks by so much [m], or after so long [s]. */
const NOTICEABLE = 2e-4;
const LATEST = 1;

/** Tiles whose recovery is due, the longest waiting first. Untouched ones have nothing to recover from. */
export function dueTiles(tiles: readonly Tile[], settings: SnowSettings, now: number): Tile[] {
  const rate = (1.5 * settings.depth) / settings.recovery + settings.snowfall;
  const age = Math.min(LATEST, NOTICEABLE / rate);
  return tiles
    .filter(({ touched, settledAt }) => touched && now - settledAt >= age)
    .sort((a, b) => a.settledAt - b.settledAt);
}

/**
 * Let recovery and snowfall catch up on tiles: as many as the bytes allow, at least one, each for the time since its
 * last turn. The law is exact for any span of time, so taking turns changes nothing but how old a tile may look.
 */
export function recoverTiles(
  passes: Passes,
  tiles: readonly Tile[],
  settings: SnowSettings,
  now: number,
  bytes = Infinity,
): void {
  const extras: [number, number][] = [];
  const slots: Rect[] = [];
  for (const tile of tiles.slice(0, Math.max(1, Math.floor(bytes / RECOVER_BYTES)))) {
    const { gain, fall } = passing(now - tile.settledAt, settings.recovery, settings.snowfall);
    tile.settledAt = now;
    if (gain === 0 && fall === 0) continue;
    extras.push([gain, fall]);
    slots.push(wrapped(tileRect(tile), passes.snow.width)[0]!);
  }
  if (slots.length === 0) return;
  passes.draw("recover", passes.other, slots, extras);
  passes.draw("copy", passes.snow, slots, [], passes.other);
}
