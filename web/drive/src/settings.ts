/**
 * Every number that a visitor can change: its range, unit and meaning. The panel, the shareable address and the
 * checks of what such an address holds are made from this table.
 */

export interface Quantity {
  readonly group: "snow" | "weather" | "car" | "picture";
  readonly value: number;
  readonly min: number;
  readonly max: number;
  readonly step: number;
  readonly unit: string;
  readonly meaning: string;
}

export interface Choice {
  readonly group: "snow" | "weather" | "car" | "picture";
  readonly value: string;
  readonly among: readonly string[];
  readonly meaning: string;
}

const quantity = (
  group: Quantity["group"],
  value: number,
  [min, max, step]: [number, number, number],
  unit: string,
  meaning: string,
): Quantity => ({ group, value, min, max, step, unit, meaning });

export const QUANTITIES = {
  depth: quantity("snow", 0.45, [0.05, 1.2, 0.01], "m", "depth of fresh snow"),
  compaction: quantity(
    "snow",
    0.7,
    [0.2, 1, 0.01],
    "",
    "share of what is pressed that is compacted; the rest goes to the rims",
  ),
  rimShare: quantity(
    "snow",
    0.75,
    [0, 1, 0.01],
    "",
    "share of the rims beside the wheel; the rest lies behind it",
  ),
  repose: quantity("snow", 42, [20, 70, 1], "°", "angle of repose, above which slopes of snow slide"),
  recovery: quantity("snow", 600, [5, 3600, 5], "s", "time constant by which tracks fade"),
  snowfall: quantity("weather", 0.0, [0, 200, 1], "mm/min", "rate at which falling snow refills tracks"),
  flakes: quantity("weather", 0.35, [0, 1, 0.05], "", "how thick the falling snow looks"),
  hour: quantity("weather", 15.2, [0, 24, 0.1], "h", "time of day"),
  fog: quantity("weather", 0.25, [0, 1, 0.01], "", "fog"),
  mass: quantity("car", 1500, [600, 4000, 50], "kg", "mass of the car"),
  power: quantity("car", 160, [30, 500, 5], "kW", "power of the engine"),
  tyreWidth: quantity("car", 0.26, [0.14, 0.5, 0.01], "m", "width of a tyre"),
  tyreRadius: quantity("car", 0.38, [0.28, 0.55, 0.01], "m", "radius of a tyre"),
  stiffness: quantity("car", 1.6, [0.8, 4, 0.1], "Hz", "frequency of the suspension"),
  exposure: quantity("picture", 1, [0.3, 3, 0.05], "", "exposure"),
} as const satisfies Record<string, Quantity>;

export const CHOICES = {
  type: {
    group: "snow",
    value: "map",
    among: ["map", "powder", "packed", "ice"],
    meaning: "type of snow: by the map, or the same everywhere",
  },
  others: {
    group: "snow",
    value: "all",
    among: ["all", "none"],
    meaning: "trails of people and animals, and another car that leaves its ruts",
  },
  drive: { group: "car", value: "all", among: ["all", "front", "rear"], meaning: "driven wheels" },
  detail: {
    group: "picture",
    value: "auto",
    among: ["auto", "high", "low"],
    meaning:
      "how fine the ground is drawn; auto is low where the processor draws; acts when the page is loaded",
  },
  photo: {
    group: "picture",
    value: "3840",
    among: ["1920", "3840", "7680"],
    meaning: "longer side of pictures that photo mode saves, in pixels",
  },
  resolution: {
    group: "picture",
    value: "1024",
    among: ["256", "512", "1024", "2048"],
    meaning: "texels along a side of the snow window",
  },
} as const satisfies Record<string, Choice>;

export type QuantityName = keyof typeof QUANTITIES;
export type ChoiceName = keyof typeof CHOICES;
export type Settings = Record<QuantityName, number> & {
  [K in ChoiceName]: (typeof CHOICES)[K]["among"][number];
};

/** The settings as they are when nothing was changed. */
export function defaults(): Settings {
  const entries = [...Object.entries(QUANTITIES), ...Object.entries(CHOICES)];
  return Object.fromEntries(entries.map(([name, { value }]) => [name, value])) as Settings;
}
