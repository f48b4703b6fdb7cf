// Which particles are water that stands together.

/** @import { State } from "./snow_cloud.js" */

const WATER = 62258; // value from which a particle is water: 0.95 of 65535
const AMONG = 8; // particles of water in the 27 cells of one spacing around one that stands in water
const FEWEST = 100; // particles that make a pool, as in the film

/**
 * Part the particles of a state into snow with lone drops, and water that stands together.
 * @param {State} state of lit snow, whose values are liquid shares
 * @param {number} spacing of particles [m]
 * @returns {{ rest: Uint16Array, pool: Uint16Array }}
 */
export function partPool({ q, n, step }, spacing) {
  const none = { rest: q, pool: q.subarray(0, 0) };
  let wet = 0;
  for (let i = 0; i < n; i++) if (q[4 * i + 3] > WATER) wet++;
  if (wet < FEWEST) return none;
  const mask = (1 << Math.ceil(Math.log2(8 * wet))) - 1; // of a table of cells, sparse: two in one place are rare
  const filled = new Uint16Array(mask + 1);
  const [a, b, c] = step.map((s) => s / spacing);
  /** @type {(x: number, y: number, z: number) => number} */
  const at = (x, y, z) =>
    (Math.imul(x, 0x9e3779b1) ^ Math.imul(y, 0x85ebca6b) ^ Math.imul(z, 0xc2b2ae35)) & mask;
  for (let i = 0; i < 4 * n; i += 4)
    if (q[i + 3] > WATER) filled[at((q[i] * a) | 0, (q[i + 1] * b) | 0, (q[i + 2] * c) | 0)]++;
  /** @type {(i: number) => boolean} */
  const stands = (i) => {
    const [x, y, z] = [(q[i] * a) | 0, (q[i + 1] * b) | 0, (q[i + 2] * c) | 0];
    let sum = 0;
    for (let k = 0; k < 27 && sum < AMONG; k++)
      sum += filled[at(x + (k % 3) - 1, y + (((k / 3) | 0) % 3) - 1, z + ((k / 9) | 0) - 1)];
    return sum >= AMONG;
  };
  const rest = new Uint16Array(4 * n);
  const pool = new Uint16Array(4 * wet);
  let [kept, stood] = [0, 0];
  for (let i = 0; i < 4 * n; i += 4) {
    const row = q.subarray(i, i + 4);
    if (q[i + 3] > WATER && stands(i)) pool.set(row, 4 * stood++);
    else rest.set(row, 4 * kept++);
  }
  if (stood < FEWEST) return none;
  return { rest: rest.subarray(0, 4 * kept), pool: pool.subarray(0, 4 * stood) };
}
