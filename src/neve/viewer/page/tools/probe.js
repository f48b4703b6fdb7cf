// The label at the pointer: what is there, and how large the brush is.

/** @import { Vec3 } from "../draw/math.js" */
/** @import { State } from "../draw/snow_cloud.js" */
/** @import { Mode } from "../protocol.js" */

import { MOST } from "../protocol.js";
import { byId, short } from "../controls/dom.js";

/**
 * Show lines of text beside the pointer; none hide the label.
 * @param {string[]} lines
 * @param {number} x of the pointer [px]
 * @param {number} y
 */
export function showProbe(lines, x, y) {
  const box = byId("probe");
  box.hidden = !lines.length;
  if (!lines.length) return;
  box.textContent = lines.join("\n");
  const left = Math.min(x + 16, window.innerWidth - box.offsetWidth - 6);
  const top = Math.min(y + 18, window.innerHeight - box.offsetHeight - 70);
  box.style.transform = `translate(${left}px, ${top}px)`;
}

/**
 * Return the value of a particle as the colours show it: an amount, a name, or nothing.
 * @param {State} state
 * @param {Mode | undefined} mode
 * @param {number} i particle
 */
export function valueText(state, mode, i) {
  if (!mode || state.mode === "snow") return "";
  const q = state.q[4 * i + 3];
  if (mode.classes) {
    const name = mode.names.find(({ value }) => value === q);
    return `${mode.label}: ${name?.text ?? q}`;
  }
  const sign = q === 0 ? "≤ " : q === MOST ? "≥ " : "";
  const unit = mode.unit && mode.unit !== "1" ? ` ${mode.unit}` : "";
  return `${mode.label}: ${sign}${short(valueAt(state, q / MOST))}${unit}`;
}

/**
 * Return the value at a share of the way from the first to the last colour.
 * @param {Pick<State, "limits" | "log">} state
 * @param {number} t
 */
export function valueAt({ limits: [low, high], log }, t) {
  return log ? low * (high / low) ** t : low + t * (high - low);
}

/**
 * Return the numbers of a vector, those that are nothing but rounding as 0.
 * @param {Vec3} vector
 */
export function numbers(vector) {
  const least = 1e-6 * Math.max(...vector.map(Math.abs));
  return vector.map((v) => short(Math.abs(v) < least ? 0 : v)).join(", ");
}

/** @param {Vec3} point */
export function placeText(point) {
  return `${numbers(point)} m`;
}
