// Perceptual colour maps of our own: in OKLab (Ottosson 2020) their lightness rises by equal steps, so that equal
// differences of a value look equally large, also in grey; hue and chroma follow smooth ways.

/** @import { Vec3 } from "./math.js" */

/** @typedef {{ lightness: [number, number], hue: [number, number], chroma: [number, number, number] }} Way hue [turns] */

/** @type {Record<string, Way>} */
const WAYS = {
  glacier: { lightness: [0.2, 0.97], hue: [0.78, 0.5], chroma: [0.08, 0.13, 0.04] },
  ember: { lightness: [0.16, 0.96], hue: [0.8, 1.27], chroma: [0.07, 0.19, 0.07] },
  meadow: { lightness: [0.2, 0.95], hue: [0.82, 0.3], chroma: [0.09, 0.14, 0.14] },
  grey: { lightness: [0.15, 0.98], hue: [0, 0], chroma: [0, 0, 0] },
};

export const MAPS = Object.keys(WAYS);

/**
 * Return the stops of a map, 0 to 255.
 * @param {string} name one of MAPS
 * @param {number} count
 * @returns {Vec3[]}
 */
export function mapStops(name, count = 33) {
  const { lightness, hue, chroma } = WAYS[name];
  return Array.from({ length: count }, (_, i) => {
    const t = i / (count - 1);
    const bend = 4 * t * (1 - t); // chroma: from the first to the last, with the second in the middle
    const c = (1 - t) * chroma[0] + t * chroma[2] + bend * (chroma[1] - 0.5 * (chroma[0] + chroma[2]));
    const h = 2 * Math.PI * (hue[0] + t * (hue[1] - hue[0]));
    const L = lightness[0] + t * (lightness[1] - lightness[0]);
    return inGamut(L, c * Math.cos(h), c * Math.sin(h));
  });
}

/**
 * Return the colour of OKLab with as much of its chroma as a screen has, 0 to 255.
 * @param {number} L
 * @param {number} a
 * @param {number} b
 * @returns {Vec3}
 */
function inGamut(L, a, b) {
  for (let k = 1; ; k -= 0.02) {
    const rgb = linear(L, k * a, k * b);
    if (k <= 0 || rgb.every((v) => v >= 0 && v <= 1)) {
      const [r, g, blue] = rgb.map((v) => Math.round(255 * curve(Math.max(0, Math.min(1, v)))));
      return [r, g, blue];
    }
  }
}

/**
 * OKLab to linear sRGB.
 * @param {number} L
 * @param {number} a
 * @param {number} b
 * @returns {Vec3}
 */
function linear(L, a, b) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

/** @param {number} v */
function curve(v) {
  return v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;
}
