/** Sun, moon and the colours of the light by time of day. Directions point to the light; x east, y up, z south. */

export type Triple = [number, number, number];

const LATITUDE = (46 * Math.PI) / 180;
// Late February: the sun stays below 33 degrees, so snow is always lit from the side.
const DECLINATION = (-11 * Math.PI) / 180;

/**
 * Direction to a body of declination `declination` [rad] at `hour` of local solar time [h]
 * (hour angle formulas, Meeus 1998, "Astronomical Algorithms", chapter 13).
 */
function direction(hour: number, declination: number): Triple {
  const angle = ((hour - 12) * Math.PI) / 12;
  const [sd, cd] = [Math.sin(declination), Math.cos(declination)];
  const [sl, cl] = [Math.sin(LATITUDE), Math.cos(LATITUDE)];
  const west = cd * Math.sin(angle);
  const south = cd * Math.cos(angle) * sl - sd * cl;
  return [-west, sl * sd + cl * cd * Math.cos(angle), south];
}

/** Direction to the sun at `hour` [h]. */
export function sunDirection(hour: number): Triple {
  return direction(hour, DECLINATION);
}

/** Direction to a full moon, which stands opposite to the sun and so high in winter. */
export function moonDirection(hour: number): Triple {
  return direction(hour + 12, -DECLINATION);
}

/** Light of an hour: linear colours, with the exposure of a camera that follows the light already in them. */
export interface Daylight {
  /** To the brighter of sun and moon. */
  readonly direction: Triple;
  /** Light of sun or moon. */
  readonly sun: Triple;
  /** Sky overhead, at the horizon, and about the sun. */
  readonly zenith: Triple;
  readonly horizon: Triple;
  readonly glow: Triple;
  /** Light from the sky, and from the snow below. */
  readonly sky: Triple;
  readonly bounce: Triple;
  /** How much of the stars is seen, 0..1; how much lamps are needed, 0..1. */
  readonly stars: number;
  readonly lamps: number;
}

type Key = [
  elevation: number,
  sun: Triple,
  zenith: Triple,
  horizon: Triple,
  glow: Triple,
  sky: Triple,
  bounce: Triple,
];

// Chosen by eye, by the sun's elevation in degrees. Below -6 the moon is the light.
const KEYS: readonly Key[] = [
  [
    -14,
    [0.3, 0.42, 0.72],
    [0.0035, 0.006, 0.016],
    [0.012, 0.02, 0.042],
    [0.01, 0.015, 0.03],
    [0.06, 0.1, 0.2],
    [0.035, 0.05, 0.09],
  ],
  [
    -7,
    [0.12, 0.17, 0.3],
    [0.012, 0.024, 0.065],
    [0.075, 0.085, 0.15],
    [0.2, 0.1, 0.08],
    [0.14, 0.2, 0.38],
    [0.08, 0.1, 0.16],
  ],
  [
    -3,
    [0.0, 0.0, 0.0],
    [0.045, 0.085, 0.21],
    [0.36, 0.27, 0.33],
    [0.75, 0.3, 0.14],
    [0.36, 0.45, 0.78],
    [0.22, 0.22, 0.3],
  ],
  [
    0,
    [1.2, 0.36, 0.12],
    [0.085, 0.17, 0.4],
    [0.62, 0.44, 0.42],
    [1.3, 0.56, 0.22],
    [0.5, 0.62, 1.0],
    [0.36, 0.32, 0.36],
  ],
  [
    4,
    [5.6, 2.75, 1.25],
    [0.12, 0.26, 0.56],
    [0.78, 0.66, 0.6],
    [1.5, 0.85, 0.42],
    [0.6, 0.8, 1.2],
    [0.5, 0.45, 0.45],
  ],
  [
    12,
    [6.6, 4.55, 2.85],
    [0.13, 0.3, 0.66],
    [0.74, 0.78, 0.82],
    [1.2, 0.95, 0.66],
    [0.66, 0.9, 1.32],
    [0.62, 0.58, 0.56],
  ],
  [
    33,
    [5.6, 4.85, 4.0],
    [0.11, 0.29, 0.68],
    [0.62, 0.76, 0.9],
    [0.9, 0.85, 0.75],
    [0.68, 0.92, 1.3],
    [0.7, 0.7, 0.7],
  ],
];

const mix = (a: number, b: number, t: number) => a + (b - a) * t;
const blend = (a: Triple, b: Triple, t: number): Triple => [
  mix(a[0], b[0], t),
  mix(a[1], b[1], t),
  mix(a[2], b[2], t),
];
const fade = (from: number, to: number, v: number) => {
  const t = Math.min(1, Math.max(0, (v - from) / (to - from)));
  return t * t * (3 - 2 * t);
};

/** The same light below clouds, `clouds` 0..1: little sun, a grey and even sky. */
export function overcast(light: Daylight, clouds: number): Daylight {
  const grey = (c: Triple, level: number): Triple => {
    const y = level * (0.3 * c[0] + 0.5 * c[1] + 0.2 * c[2]);
    return [0.97 * y, y, 1.06 * y];
  };
  const above = grey(light.horizon, 0.95);
  return {
    ...light,
    sun: blend(light.sun, grey(light.sun, 0.12), clouds),
    zenith: blend(light.zenith, above, 0.9 * clouds),
    horizon: blend(light.horizon, grey(light.horizon, 1), 0.7 * clouds),
    glow: blend(light.glow, [0, 0, 0], 0.9 * clouds),
    sky: blend(light.sky, grey(light.sky, 1.5), clouds),
    bounce: blend(light.bounce, grey(light.bounce, 1.3), clouds),
    stars: light.stars * (1 - clouds),
  };
}

/** The light at `hour` [h]. */
export function daylight(hour: number): Daylight {
  const toSun = sunDirection(hour);
  const elevation = (Math.asin(toSun[1]) * 180) / Math.PI;
  const next = KEYS.findIndex(([e]) => e > elevation);
  const b = KEYS[next < 0 ? KEYS.length - 1 : next]!;
  const a = KEYS[next < 0 ? KEYS.length - 1 : Math.max(0, next - 1)]!;
  const t = a === b ? 0 : (elevation - a[0]) / (b[0] - a[0]);
  return {
    // The moon takes over where the sun's light is nought.
    direction: elevation > -3 ? toSun : moonDirection(hour),
    sun: blend(a[1], b[1], t),
    zenith: blend(a[2], b[2], t),
    horizon: blend(a[3], b[3], t),
    glow: blend(a[4], b[4], t),
    sky: blend(a[5], b[5], t),
    bounce: blend(a[6], b[6], t),
    stars: 1 - fade(-11, -4, elevation),
    lamps: 1 - fade(-1.5, 5, elevation),
  };
}
