/**
 * The types of snow that the map tells apart. The figures are chosen for play: their order of magnitude is that of
 * snow (fresh snow near 100 kg/m3, a groomed road near 400, tyres press with 20 to 150 kPa), their exact values are
 * what drives well.
 */
export interface SnowType {
  readonly name: string;
  /** Strain under boundless pressure, 0..1: how much there is to press. */
  readonly strain: number;
  /** Pressure that brings 63 % of it [Pa]. */
  readonly pressure: number;
  /** Density before anything pressed it [kg/m3]; for the reader: the game reckons in depths of fresh snow. */
  readonly density: number;
  /** Friction of a tyre along its heading. */
  readonly friction: number;
  /** Friction of a tyre across its heading. */
  readonly sideFriction: number;
  /** Factor of the work of compaction that slows a rolling wheel. */
  readonly drag: number;
}

export const SNOW_TYPES = {
  powder: {
    name: "powder",
    strain: 0.72,
    pressure: 26e3,
    density: 110,
    friction: 0.42,
    sideFriction: 0.38,
    drag: 1,
  },
  packed: {
    name: "packed",
    strain: 0.15,
    pressure: 180e3,
    density: 420,
    friction: 0.5,
    sideFriction: 0.46,
    drag: 0.6,
  },
  ice: {
    name: "ice",
    strain: 0.02,
    pressure: 2e6,
    density: 880,
    friction: 0.14,
    sideFriction: 0.11,
    drag: 0.2,
  },
} as const satisfies Record<string, SnowType>;

export type SnowTypeName = keyof typeof SNOW_TYPES;

/** The order of the shares that `Terrain.kinds` gives. */
export const SNOW_ORDER = ["powder", "packed", "ice"] as const satisfies readonly SnowTypeName[];

/**
 * The type between types, by their shares (sum 1, in SNOW_ORDER), with a powder that may be another than the usual one: pressures by their geometric mean, because they
 * lie orders of magnitude apart, everything else by the plain one.
 */
export function mixSnow(
  shares: readonly [number, number, number],
  powder: SnowType = SNOW_TYPES.powder,
): SnowType {
  const types = SNOW_ORDER.map((name) => (name === "powder" ? powder : SNOW_TYPES[name]));
  const sum = (of: (type: SnowType) => number) =>
    types.reduce((total, type, i) => total + shares[i]! * of(type), 0);
  const largest = shares.indexOf(Math.max(...shares));
  return {
    name: (types[largest] ?? powder).name,
    strain: sum((type) => type.strain),
    pressure: Math.exp(sum((type) => Math.log(type.pressure))),
    density: sum((type) => type.density),
    friction: sum((type) => type.friction),
    sideFriction: sum((type) => type.sideFriction),
    drag: sum((type) => type.drag),
  };
}
