// Colours of values: of amounts from a mode's own stops, of names by turning the hue.

/** @import { Vec3 } from "./math.js" */

import { V } from "./math.js";

/**
 * Return the colour of a name, 0 to 255, as the shader `named` has it.
 * @param {number} value
 * @returns {Vec3}
 */
export function nameColor(value) {
  if (!value) return [128, 128, 128];
  const turn = ((value * 0.61803399) % 1) * 6.2831853;
  /** @param {number} phase */
  const channel = (phase) => Math.round(255 * (0.42 + 0.34 * Math.cos(turn + phase)));
  return [channel(0), channel(2.1), channel(4.2)];
}

/**
 * Return a table of `size` colours, red, green, blue and opacity, that runs through the stops.
 * @param {Vec3[]} stops
 * @param {number} size
 */
export function colorTable(stops, size) {
  const table = new Uint8Array(4 * size);
  for (let i = 0; i < size; i++) {
    const t = (i / (size - 1)) * (stops.length - 1);
    const k = Math.min(Math.floor(t), stops.length - 2);
    table.set([...V.mix(stops[k], stops[k + 1], t - k), 255], 4 * i);
  }
  return table;
}
