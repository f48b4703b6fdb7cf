/**
 * Smooth noise on the plane, from nothing but integers: gradient noise after Perlin (2002, "Improving noise"), with his
 * quintic blend, so that the second derivative is continuous and slopes have no creases along the cells.
 */

const DIRECTIONS = 64;
const COSINES = Float64Array.from({ length: DIRECTIONS }, (_, k) => Math.cos((2 * Math.PI * k) / DIRECTIONS));
const SINES = Float64Array.from({ length: DIRECTIONS }, (_, k) => Math.sin((2 * Math.PI * k) / DIRECTIONS));

/** Largest value of two-dimensional gradient noise with unit gradients is sqrt(1/2); this brings it to 1. */
const TO_ONE = Math.SQRT2;

/** A well-mixed 32-bit number of two whole numbers and a seed. */
export function hash(i: number, j: number, seed: number): number {
  let h = Math.imul(i, 0x27d4eb2d) ^ Math.imul(j, 0x165667b1) ^ Math.imul(seed, 0x9e3779b1);
  h = Math.imul(h ^ (h >>> 15), 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
  return (h ^ (h >>> 16)) >>> 0;
}

/** A number in [0, 1) that belongs to two whole numbers and a seed. */
export function random(i: number, j: number, seed: number): number {
  return hash(i, j, seed) / 4294967296;
}

/** Cubic step from 0 at `from` to 1 at `to`, level outside; `from` may be above `to`. */
export function smoothstep(from: number, to: number, x: number): number {
  const t = Math.min(1, Math.max(0, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
}

/** Straight blend from a (t = 0) to b (t = 1). */
export function mix(a: number, b: number, t: number): number {
  return a + (b - a) * t;
}

/** Height of the noise, -1..1, and its gradient with respect to x and z, for a cell of size 1. */
export interface Sample {
  value: number;
  dx: number;
  dz: number;
}

/** Noise at (x, z) with its gradient, written into `out`. */
export function noiseWithSlope(x: number, z: number, seed: number, out: Sample): Sample {
  const i = Math.floor(x);
  const j = Math.floor(z);
  const u = x - i;
  const v = z - j;
  const a = hash(i, j, seed) % DIRECTIONS;
  const b = hash(i + 1, j, seed) % DIRECTIONS;
  const c = hash(i, j + 1, seed) % DIRECTIONS;
  const d = hash(i + 1, j + 1, seed) % DIRECTIONS;
  const va = COSINES[a]! * u + SINES[a]! * v;
  const vb = COSINES[b]! * (u - 1) + SINES[b]! * v;
  const vc = COSINES[c]! * u + SINES[c]! * (v - 1);
  const vd = COSINES[d]! * (u - 1) + SINES[d]! * (v - 1);
  const s = u * u * u * (u * (u * 6 - 15) + 10);
  const t = v * v * v * (v * (v * 6 - 15) + 10);
  const ds = 30 * u * u * (u - 1) * (u - 1);
  const dt = 30 * v * v * (v - 1) * (v - 1);
  const twist = va - vb - vc + vd;
  const gx = mix(mix(COSINES[a]!, COSINES[b]!, s), mix(COSINES[c]!, COSINES[d]!, s), t);
  const gz = mix(mix(SINES[a]!, SINES[b]!, s), mix(SINES[c]!, SINES[d]!, s), t);
  out.value = TO_ONE * mix(mix(va, vb, s), mix(vc, vd, s), t);
  out.dx = TO_ONE * (gx + ds * (vb - va + t * twist));
  out.dz = TO_ONE * (gz + dt * (vc - va + s * twist));
  return out;
}

const scratch: Sample = { value: 0, dx: 0, dz: 0 };

/** Noise at (x, z), -1..1, for a cell of size 1. */
export function noise(x: number, z: number, seed: number): number {
  return noiseWithSlope(x, z, seed, scratch).value;
}

/** Ridged noise, 0..1: sharp crests where plain noise crosses zero (Musgrave's ridged multifractal, first power). */
export function ridges(x: number, z: number, seed: number, octaves: number): number {
  let sum = 0;
  let share = 0.5;
  let weight = 1;
  let scale = 1;
  for (let octave = 0; octave < octaves; octave++) {
    const crest = 1 - Math.abs(noise(x * scale, z * scale, seed + octave));
    sum += share * weight * crest * crest;
    weight = Math.min(1, crest * crest * 1.5);
    share *= 0.5;
    scale *= 2.03;
  }
  return sum;
}
