// Plots over time: figures of the run, a chart for each unit, with the moment that is shown.

/** @import { FiguresMessage, SceneMessage } from "../protocol.js" */
/** @import { App } from "../main.js" */
/** @typedef {{ unit: string, names: string[], canvas: HTMLCanvasElement, told: HTMLElement }} Chart */

import { button, make, select, short } from "./dom.js";

const HIGH = 104; // px
const LEFT = 46; // px for the numbers
const EDGE = 7;
const FIRST = ["kinetic", "elastic", "potential"]; // what is plotted if nothing was chosen
const COLORS = ["#8fc7ff", "#ffb070", "#9fe0a8", "#e29fd8", "#f2e08a", "#b0b8ff"];
const MOST = 12; // curves

export class Plots {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.asked = false;
    /** @type {FiguresMessage["columns"]} */
    this.columns = [];
    /** @type {FiguresMessage["rows"]} */
    this.rows = [];
    /** @type {Map<string, number>} where in a row each figure is */
    this.places = new Map();
    this.chosen = [...FIRST];
    /** @type {Chart[]} */
    this.charts = [];
    /** @type {number | null} row under the pointer */
    this.over = null;
    this.live = true;
    this.name = ""; // of the scene
    this.stale = false;
    this.choice = select({ title: "Plot one more figure" }, []);
    this.choice.setAttribute("aria-label", "figure to plot");
    this.choice.addEventListener("change", () => this.toggle(this.choice.value));
    const save = button(null, "Save all figures as a table (CSV)", () => this.save(), "CSV");
    this.place = make("div", { class: "charts" });
    this.root = make("div", {}, make("div", { class: "buttons" }, this.choice, save), this.place);
  }

  /** Ask for the figures, once they are to be seen. */
  begin() {
    this.asked = true;
    this.app.send({ do: "plot" });
  }

  /** @param {SceneMessage} scene */
  show(scene) {
    this.live = scene.live;
    if (this.name === scene.name) return;
    this.name = scene.name;
    this.rows = [];
    if (this.asked) this.begin();
  }

  /** @param {FiguresMessage} message */
  hear({ first, columns, rows }) {
    if (first > this.rows.length) {
      this.begin(); // some were lost on the way
      return;
    }
    const known = this.columns.map((column) => column.name).join();
    this.rows.length = first;
    this.rows.push(...rows);
    this.columns = columns;
    this.places = new Map(columns.map((column, k) => [column.name, k + 1]));
    if (known !== columns.map((column) => column.name).join()) this.arrange();
    this.stale = true;
  }

  /** @param {string} name of a curve, which appears or goes */
  toggle(name) {
    if (!name) return;
    if (this.chosen.includes(name)) this.chosen = this.chosen.filter((other) => other !== name);
    else this.chosen = [...this.chosen, name].slice(-MOST);
    this.arrange();
  }

  /** Make the list of figures, and a chart for each unit. */
  arrange() {
    const names = this.columns.map((column) => column.name).filter((name) => name !== "time");
    this.choice.replaceChildren(
      make("option", { value: "" }, "plot …"),
      ...names.map((name) =>
        make("option", { value: name }, `${this.chosen.includes(name) ? "✓ " : ""}${name}`),
      ),
    );
    this.choice.value = "";
    /** @type {Map<string, string[]>} */
    const units = new Map();
    for (const { name, unit } of this.columns) {
      if (!this.chosen.includes(name)) continue;
      const key = unit || name; // pure numbers have nothing in common
      units.set(key, [...(units.get(key) ?? []), name]);
    }
    this.charts = [...units].map(([unit, curves]) => this.chart(unit, curves));
    this.place.replaceChildren(...this.charts.flatMap(({ canvas, told }) => [told, canvas]));
    this.stale = true;
  }

  /**
   * @param {string} unit
   * @param {string[]} names
   * @returns {Chart}
   */
  chart(unit, names) {
    const canvas = make("canvas", { class: "chart", height: HIGH });
    canvas.setAttribute("aria-label", `${names.join(", ")} over time`);
    const told = make("div", { class: "told" });
    const chart = { unit, names, canvas, told };
    canvas.addEventListener("pointermove", (event) => {
      this.over = this.rowAt(chart, event.offsetX);
      if (event.buttons) this.seek();
      this.stale = true;
    });
    canvas.addEventListener("pointerdown", (event) => {
      this.over = this.rowAt(chart, event.offsetX);
      this.seek();
    });
    canvas.addEventListener("pointerleave", () => {
      this.over = null;
      this.stale = true;
    });
    return chart;
  }

  /** Show the frame under the pointer, where a run has frames. */
  seek() {
    if (this.live || this.over === null) return;
    this.app.send({ do: "seek", time: this.value(this.over, "time") });
  }

  /** @param {number} row @param {string} name */
  value(row, name) {
    return this.rows[row]?.[this.places.get(name) ?? -1] ?? null;
  }

  /** First and last time [s]. */
  span() {
    const times = [this.value(0, "time") ?? 0, this.value(this.rows.length - 1, "time") ?? 1];
    return times[1] > times[0] ? times : [times[0], times[0] + 1];
  }

  /**
   * @param {Chart} chart
   * @param {number} x [px]
   */
  rowAt({ canvas }, x) {
    if (!this.rows.length) return null;
    const [from, to] = this.span();
    const time = from + ((x - LEFT) / Math.max(1, canvas.clientWidth - LEFT - EDGE)) * (to - from);
    return this.nearest(time);
  }

  /** @param {number} time @returns {number} the row next to it */
  nearest(time) {
    let [low, high] = [0, this.rows.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((this.value(middle, "time") ?? 0) <= time) low = middle;
      else high = middle;
    }
    /** @param {number} row */
    const far = (row) => Math.abs((this.value(row, "time") ?? 0) - time);
    return far(high) < far(low) ? high : low;
  }

  /** Draw what has changed, if it is to be seen. */
  tick() {
    if (!this.stale || !this.root.isConnected || this.root.offsetParent === null) return;
    this.stale = false;
    for (const chart of this.charts) this.draw(chart);
  }

  /** @param {Chart} chart */
  draw(chart) {
    const { canvas, names } = chart;
    const scale = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(HIGH * scale);
    const context = canvas.getContext("2d");
    if (!context) return;
    context.scale(scale, scale);
    const [low, high] = this.limits(names);
    const [from, to] = this.span();
    /** @param {number} time */
    const x = (time) => LEFT + ((time - from) / (to - from)) * (width - LEFT - EDGE);
    /** @param {number} value */
    const y = (value) => HIGH - EDGE - ((value - low) / (high - low)) * (HIGH - 2 * EDGE);
    drawAxes(context, width, low, high, y);
    names.forEach((name, k) => {
      context.strokeStyle = COLORS[k % COLORS.length];
      this.curve(context, name, x, y);
    });
    const shown = this.nearest(this.app.state?.time ?? 0);
    context.fillStyle = "rgba(255, 255, 255, 0.75)";
    context.fillRect(x(this.app.state?.time ?? 0) - 0.5, EDGE, 1, HIGH - 2 * EDGE);
    if (this.over !== null) {
      context.fillStyle = "rgba(140, 200, 255, 0.9)";
      context.fillRect(x(this.value(this.over, "time") ?? 0) - 0.5, EDGE, 1, HIGH - 2 * EDGE);
    }
    this.tell(chart, this.over ?? shown);
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {string} name
   * @param {(time: number) => number} x
   * @param {(value: number) => number} y
   */
  curve(context, name, x, y) {
    context.lineWidth = 1.5;
    context.beginPath();
    let down = false;
    for (let row = 0; row < this.rows.length; row++) {
      const [time, value] = [this.value(row, "time"), this.value(row, name)];
      if (time === null || value === null) {
        down = false;
        continue;
      }
      if (down) context.lineTo(x(time), y(value));
      else context.moveTo(x(time), y(value));
      down = true;
    }
    context.stroke();
  }

  /** @param {string[]} names @returns {[number, number]} */
  limits(names) {
    let [low, high] = [Infinity, -Infinity];
    for (let row = 0; row < this.rows.length; row++)
      for (const name of names) {
        const value = this.value(row, name);
        if (value === null) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    if (low > high) return [0, 1];
    return low === high
      ? [low - 0.5 * Math.max(1, Math.abs(low)), high + 0.5 * Math.max(1, Math.abs(high))]
      : [low, high];
  }

  /**
   * Say the values of a row above the chart.
   * @param {Chart} chart
   * @param {number} row
   */
  tell({ names, unit, told }, row) {
    const time = this.value(row, "time");
    const parts = names.map((name, k) => {
      const text = make(
        "span",
        {},
        `${name} ${short(this.value(row, name))}${names.includes(unit) ? "" : ` ${unit}`}`,
      );
      text.style.color = COLORS[k % COLORS.length];
      return text;
    });
    told.replaceChildren(...parts, make("span", {}, `at ${short(time)} s`));
  }

  /** The figures as text: a line of names, then a line for each frame. */
  csv() {
    /** @param {string | number | null} cell */
    const text = (cell) =>
      typeof cell === "string" && /[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : (cell ?? "");
    const names = this.columns.map(({ name }) => name.replaceAll(" ", "_"));
    const lines = [["frame", ...names], ...this.rows].map((row) => row.map(text).join());
    return `${lines.join("\n")}\n`;
  }

  save() {
    const url = URL.createObjectURL(new Blob([this.csv()], { type: "text/csv" }));
    make("a", { href: url, download: `${this.app.scene?.name ?? "run"}-figures.csv` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} low
 * @param {number} high
 * @param {(value: number) => number} y
 */
function drawAxes(context, width, low, high, y) {
  context.font = "10px system-ui, sans-serif";
  context.textAlign = "right";
  context.textBaseline = "middle";
  const marks = [low, 0.5 * (low + high), high];
  for (const value of marks) {
    context.fillStyle = "#9fb0c3";
    context.fillText(short(value), LEFT - 5, y(value));
    context.fillStyle = "rgba(255, 255, 255, 0.10)";
    context.fillRect(LEFT, y(value) - 0.5, width - LEFT - EDGE, 1);
  }
}
