import type { Both } from "../bridge/playback";

/** What the page says of a wheel that was recorded and of the game's beside it. */
export function tellBridge(name: string, { load, recorded, game }: Both): string {
  const cm = (metres: number) => `${(100 * metres).toFixed(1)} cm`;
  return [
    `${name}: ${(load / 1e3).toFixed(1)} kN on each wheel`,
    `left, by the material point method: ${cm(recorded)} in`,
    `right, by the law of the game: ${cm(game)} in`,
  ].join("\n");
}
