// The legend of the colours: a ramp with its values and how many particles have each, or names.

/** @import { LegendName, Mode } from "../protocol.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @import { State } from "../draw/snow_cloud.js" */
/** @import { Child } from "./dom.js" */

import { colorTable, nameColor } from "../draw/colors.js";
import { byId, make, short } from "./dom.js";
import { valueAt } from "../tools/probe.js";

const WIDTH = 220;
const HEIGHT = 34;
const BINS = 55;
const SAMPLE = 100_000; // particles of which a histogram is made, at most

export class Legend {
  /** @param {(mode: Mode) => Vec3[]} stops colours of a mode */
  constructor(stops) {
    this.root = byId("legend");
    this.stops = stops;
    this.key = "";
    this.counted = make("canvas", { width: WIDTH, height: HEIGHT, class: "histogram" });
    this.counted.setAttribute("aria-label", "how many particles have each value");
    /** @type {number[]} */
    this.counts = [];
  }

  /**
   * @param {Pick<State, "mode" | "limits" | "log">} state
   * @param {Mode | undefined} mode
   */
  show(state, mode) {
    this.root.hidden = !mode || state.mode === "snow";
    if (this.root.hidden || !mode) {
      this.key = "";
      return;
    }
    const stops = this.stops(mode);
    const key = JSON.stringify([state.mode, state.limits, state.log, mode.names, stops]);
    if (key === this.key) return;
    this.key = key;
    const title = make("div", {}, mode.label + (mode.unit && mode.unit !== "1" ? ` [${mode.unit}]` : ""));
    this.root.replaceChildren(title, ...(mode.classes ? mode.names.map(nameLine) : this.ramp(stops, state)));
  }

  /**
   * @param {Vec3[]} stops
   * @param {Pick<State, "limits" | "log">} state
   * @returns {HTMLElement[]}
   */
  ramp(stops, state) {
    const strip = make("canvas", { width: WIDTH, height: 1 });
    const pixels = new ImageData(new Uint8ClampedArray(colorTable(stops, WIDTH)), WIDTH, 1);
    strip.getContext("2d")?.putImageData(pixels, 0, 0);
    /** @type {Child[]} */
    const ends = [0, 0.5, 1].map((t) => make("span", {}, short(valueAt(state, t))));
    return [this.counted, strip, make("div", { class: "ends" }, ...ends)];
  }

  /**
   * Count the values of a sample of the particles.
   * @param {Pick<State, "n" | "q" | "classes" | "mode">} state
   */
  count({ n, q, classes, mode }) {
    if (this.root.hidden || classes || mode === "snow") return;
    const counts = new Array(BINS).fill(0);
    const stride = Math.max(1, Math.ceil(n / SAMPLE));
    for (let i = 0; i < n; i += stride) counts[(q[4 * i + 3] * BINS) >> 16] += 1;
    this.counts = counts;
    const context = this.counted.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, WIDTH, HEIGHT);
    context.fillStyle = "#cfe0f2";
    const most = Math.sqrt(Math.max(1, ...counts)); // roots, so that what is rare is seen, too
    counts.forEach((many, k) => {
      const high = (HEIGHT - 1) * (Math.sqrt(many) / most);
      context.fillRect((k * WIDTH) / BINS, HEIGHT - high, WIDTH / BINS - 1, high);
    });
  }
}

/** @param {LegendName} name */
function nameLine({ value, text }) {
  if (value === null) return make("div", { class: "name" }, text);
  const dot = make("span", { class: "dot" });
  dot.style.background = `rgb(${nameColor(value)})`;
  return make("div", { class: "name" }, dot, text);
}
