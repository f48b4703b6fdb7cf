// The colours of the snow, chosen in the panel: mode, map, ends of the legend, powers; and the plane that cuts.

/** @import { Mode, SceneMessage } from "../protocol.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @import { App } from "../main.js" */
/** @typedef {{ map: string, limits: [number, number] | null, log: boolean }} Choice */

import { MAPS, mapStops } from "../draw/maps.js";
import { button, make, say, select, short } from "./dom.js";

const OWN = "of the mode";
const AXES = ["x", "y", "z"];

export class ColorsSection {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {Map<string, Choice>} what was chosen for each mode */
    this.choices = new Map();
    this.low = input("value of the first colour", () => this.setLimits());
    this.high = input("value of the last colour", () => this.setLimits());
    this.cut = { axis: -1, share: 0.5, back: false };
  }

  /** @param {string} mode @returns {Choice} */
  of(mode) {
    const known = this.choices.get(mode) ?? { map: OWN, limits: null, log: false };
    this.choices.set(mode, known);
    return known;
  }

  /**
   * Return the colours of a mode from the least to the greatest value.
   * @param {Mode} mode
   * @returns {Vec3[]}
   */
  stops(mode) {
    const { map } = this.of(mode.name);
    return map === OWN ? mode.stops : mapStops(map);
  }

  /** Tell the server what is chosen. */
  send() {
    const { mode } = this.app;
    const { limits, log } = this.of(mode);
    this.app.send({ do: "color_mode", mode, limits, log });
  }

  /**
   * @param {SceneMessage} scene
   * @param {(label: string, ...content: import("./dom.js").Child[]) => HTMLElement} row
   */
  rows(scene, row) {
    const { app } = this;
    /** @type {[string, string][]} */
    const modes = scene.modes.map((m) => [m.name, m.label]);
    const onchange = () => {
      app.setMode(mode.value);
      fill();
    };
    const mode = select({ id: "mode", onchange }, modes);
    mode.value = app.mode;
    const map = select(
      { id: "map", onchange: () => this.setMap(map.value) },
      [OWN, ...MAPS].map((m) => [m, m]),
    );
    const log = make("input", { type: "checkbox", id: "log" });
    log.addEventListener("change", () => {
      this.of(app.mode).log = log.checked;
      this.send();
    });
    const auto = button(null, "Find the ends of the legend from the values", () => this.setAuto(), "auto");
    const more = [row("map", map), row("from, to", this.low, this.high, auto), row("log scale", log)];
    more[1].classList.add("wide");
    const fill = () => {
      const shown = scene.modes.find((m) => m.name === app.mode);
      for (const each of more) each.hidden = !shown || shown.name === "snow" || shown.classes;
      const choice = this.of(app.mode);
      map.value = choice.map;
      log.checked = choice.log;
      this.low.value = choice.limits ? short(choice.limits[0]) : "";
      this.high.value = choice.limits ? short(choice.limits[1]) : "";
    };
    fill();
    return [row("colours", mode), ...more, this.cutRow(row)];
  }

  /** @param {string} map */
  setMap(map) {
    const { app } = this;
    this.of(app.mode).map = map;
    const mode = app.scene?.modes.find((m) => m.name === app.mode);
    if (mode) app.stage.setPalette(mode.name, this.stops(mode));
    if (app.state) app.bar.showState(app.state);
    app.redraw();
  }

  setLimits() {
    const texts = [this.low.value.trim(), this.high.value.trim()];
    if (texts.includes("")) return;
    const [low, high] = texts.map(Number);
    if (!(low < high)) {
      say("the last colour needs a greater value than the first", true);
      return;
    }
    this.of(this.app.mode).limits = [low, high];
    this.send();
  }

  setAuto() {
    this.of(this.app.mode).limits = null;
    this.low.value = this.high.value = "";
    this.send();
  }

  /** @param {(label: string, ...content: import("./dom.js").Child[]) => HTMLElement} row */
  cutRow(row) {
    const { cut } = this;
    const act = () => {
      cut.axis = AXES.indexOf(axis.value);
      cut.share = Number(share.value);
      this.setCut();
    };
    const axis = select(
      { id: "cut", onchange: act },
      ["no cut", ...AXES].map((a) => [a, a]),
    );
    axis.value = AXES[cut.axis] ?? "no cut";
    const share = make("input", { type: "range", min: 0, max: 1, step: 0.005, value: cut.share });
    share.setAttribute("aria-label", "where the plane cuts");
    share.addEventListener("input", act);
    const turn = button(
      null,
      "Cut away the other side",
      () => {
        cut.back = !cut.back;
        act();
      },
      "⇄",
    );
    return row("cut", axis, share, turn);
  }

  /** Cut at the chosen share of the snow's extent. */
  setCut() {
    const { app, cut } = this;
    const [x, y, z, radius] = app.stage.snow.ball;
    const sign = cut.back ? -1 : 1;
    /** @type {Vec3} */
    const normal = [0, 0, 0];
    if (cut.axis >= 0) normal[cut.axis] = sign;
    const at = sign * ([x, y, z][cut.axis] + (2 * cut.share - 1) * radius);
    app.stage.setClip(cut.axis < 0 ? null : { normal, at });
    app.redraw();
  }
}

/**
 * @param {string} label
 * @param {() => void} onchange
 */
function input(label, onchange) {
  const element = make("input", { type: "text", inputMode: "decimal", spellcheck: false, onchange });
  element.setAttribute("aria-label", label);
  element.addEventListener("keydown", (event) => event.stopPropagation());
  return element;
}
