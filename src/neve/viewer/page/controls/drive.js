// The controls of motors and robots: a slider for each, and two keys for each of the first four.

/** @import { RobotControl, SceneMessage } from "../protocol.js" */
/** @import { App } from "../main.js" */
/** @typedef {{ control: RobotControl, slider: HTMLInputElement, told: HTMLElement }} Row */

import { button, make, short } from "./dom.js";

const KEYS = ["tg", "uj", "ik", "ol"]; // more and less of the first four
const SWEEP = 1.5; // s from one end of the range to the other while a key is held

export class Drive {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {Row[]} */
    this.rows = [];
    this.root = make("div", {});
    this.key = "";
  }

  /** @param {SceneMessage} scene */
  show({ controls, name }) {
    const key = JSON.stringify([name, controls.map((control) => [control.name, control.low, control.high])]);
    if (key === this.key) return;
    this.key = key;
    this.rows = controls.map((control) => this.row(control));
    const hint = "Held here until ↺ gives it back to the scene; the letters are keys.";
    this.root.replaceChildren(
      make("p", { class: "hint" }, controls.length ? hint : "This scene has no motors and no robots."),
      ...this.rows.map(({ slider, told, control }, i) => {
        const label = make(
          "label",
          { title: control.name },
          KEYS[i] ? `${[...KEYS[i]].join("/")} ` : "",
          control.name,
        );
        const back = button(null, `Give ${control.name} back to the scene`, () => this.release(i), "↺");
        return make("div", { class: "row" }, label, make("div", { class: "value" }, slider, told, back));
      }),
    );
  }

  /** @param {RobotControl} control @returns {Row} */
  row(control) {
    const { low, high, value, name } = control;
    const slider = make("input", { type: "range", min: low, max: high, step: (high - low) / 400 });
    slider.value = String(value);
    slider.setAttribute("aria-label", name);
    const told = make("span", { class: "unit" }, short(value));
    const row = { control, slider, told };
    slider.addEventListener("input", () => this.send(row));
    return row;
  }

  /** @param {Row} row */
  send({ control, slider, told }) {
    told.textContent = short(Number(slider.value));
    this.app.send({ do: "drive", name: control.name, value: Number(slider.value) });
  }

  /** @param {number} i */
  release(i) {
    this.rows[i].told.textContent = "scene";
    this.app.send({ do: "drive", name: this.rows[i].control.name, value: null });
  }

  /**
   * Move the sliders whose keys are held.
   * @param {number} seconds
   */
  tick(seconds) {
    const { keys } = this.app.camera;
    this.rows.slice(0, KEYS.length).forEach((row, i) => {
      const [more, less] = KEYS[i];
      const way = Number(keys.has(more)) - Number(keys.has(less));
      if (!way) return;
      const { low, high } = row.control;
      const next = Number(row.slider.value) + (way * (high - low) * seconds) / SWEEP;
      const value = String(Math.min(high, Math.max(low, next)));
      row.slider.step = "any";
      row.slider.value = value;
      this.send(row);
    });
  }
}
