import type { Terrain } from "./terrain_type";
import type { Settings } from "../settings";

const SHARES: Record<Exclude<Settings["type"], "map">, [number, number, number]> = {
  powder: [1, 0, 0],
  packed: [0, 1, 0],
  ice: [0, 0, 1],
};

/** The same ground with the type of snow that `choose` names everywhere; with "map" its own. */
export function withType(terrain: Terrain, choose: () => Settings["type"]): Terrain {
  return {
    height: (x, z) => terrain.height(x, z),
    slope: (x, z) => terrain.slope(x, z),
    cover: (x, z) => terrain.cover(x, z),
    kinds: (x, z) => {
      const type = choose();
      return type === "map" ? terrain.kinds(x, z) : [...SHARES[type]];
    },
  };
}
