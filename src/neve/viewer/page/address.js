// What the address of the page says after its #: key=value pairs, joined by &.

/**
 * @param {string} hash
 * @param {string} key
 * @returns {string} empty if it is not there
 */
export function inHash(hash, key) {
  return new URLSearchParams(hash.replace(/^#/, "")).get(key) ?? "";
}

/**
 * Return the resolution that an address asks for, from 0.1 to 2; 0 if none.
 * @param {string} hash
 */
export function resolutionOf(hash) {
  const asked = Number(inHash(hash, "resolution"));
  return asked > 0 ? Math.min(2, Math.max(0.1, asked)) : 0;
}

/**
 * Return an address's end with another value of a key.
 * @param {string} hash
 * @param {string} key
 * @param {string} value
 */
export function withHash(hash, key, value) {
  const pairs = new URLSearchParams(hash.replace(/^#/, ""));
  pairs.set(key, value);
  return `#${pairs.toString().replaceAll("%2F", "/")}`;
}
