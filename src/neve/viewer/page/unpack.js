// The positions of a replay; src/neve/viewer/exports/replay.py packs them and says how.

/**
 * Return the positions of each key: x of all particles, then y, then z.
 * @param {Uint8Array} raw low bytes, then high bytes, of each key
 * @param {number} n particles
 * @param {number[]} keys their frames
 */
export function unpack(raw, n, keys) {
  /** @type {Uint16Array[]} */
  const found = [];
  const size = 3 * n;
  keys.forEach((_, k) => {
    const places = predict(found, keys, k, size);
    const low = raw.subarray(2 * size * k);
    const high = raw.subarray(2 * size * k + size);
    for (let i = 0; i < size; i++) {
      const folded = low[i] | (high[i] << 8);
      places[i] += (folded >>> 1) ^ -(folded & 1);
    }
    found.push(places);
  });
  return found;
}

/**
 * Return where key k would be after the two before it at a steady pace, modulo 65536; whole numbers alone.
 * @param {Uint16Array[]} found
 * @param {number[]} keys
 * @param {number} k
 * @param {number} size
 */
function predict(found, keys, k, size) {
  if (k === 0) return new Uint16Array(size);
  const before = found[k - 1];
  const ahead = new Uint16Array(before);
  if (k === 1) return ahead;
  const earlier = found[k - 2];
  const now = keys[k] - keys[k - 1];
  const then = keys[k - 1] - keys[k - 2];
  for (let i = 0; i < size; i++) {
    const way = ((before[i] - earlier[i]) << 16) >> 16;
    ahead[i] += Math.floor((2 * way * now + then) / (2 * then));
  }
  return ahead;
}
