// The bar below: play, pace, timeline and clock; and the figures and the legend in the corners.

/** @import { Command } from "../commands.js" */
/** @import { Drawn, Mode, PlayerState } from "../protocol.js" */
/** @import { State } from "../draw/snow_cloud.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @typedef {Pick<State, "n" | "q" | "time" | "frame" | "mode" | "limits" | "log" | "classes" | "facts">} BarState what the bar shows */
/**
 * @typedef {object} Host
 * @property {Drawn | null} scene
 * @property {(command: Command) => void} send
 * @property {() => void} [togglePanel] where there is a panel
 * @property {(mode: Mode) => Vec3[]} [stops] colours of a mode, if others than its own can be chosen
 */

import { button, byId, icon, make, select, short } from "./dom.js";
import { Legend } from "./legend.js";

// The stages of a step come from the solver, in its order; they get these colours one after the other.
const STAGE_COLORS = ["#c08fd8", "#8fb8de", "#6c8fb0", "#4f9dd8", "#9fd0a8", "#d8b25a", "#d8805a", "#b0b0b0"];
const REST_COLOR = "#5d6b7c"; // sorts, snapshots for the pages, what is in no stage
const SPEEDS = [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 4];

/** Count how often something has happened lately. */
export class Rate {
  constructor() {
    /** @type {number[]} clock of each time [ms] */
    this.times = [];
  }

  add() {
    this.times.push(performance.now());
  }

  text() {
    const now = performance.now();
    const times = this.times;
    while (times.length > 2 && now - times[0] > 1500) times.shift(); // two tell how slow it is
    const first = times[0];
    const last = times[times.length - 1];
    if (times.length < 2 || now - last > 2 * (last - first) + 1500) return "0";
    const rate = ((times.length - 1) * 1000) / Math.max(last - first, 1);
    return rate.toFixed(rate < 9.95 ? 1 : 0);
  }
}

export class Bar {
  /** @param {Host} host */
  constructor(host) {
    this.host = host;
    this.root = byId("bar");
    this.playing = false;
    this.pictures = new Rate();
    this.updates = new Rate();
    /** @type {BarState | null} */
    this.state = null;
    this.duration = 0; // of the scene [s]; 0: none is told
    this.shown = 0; // clock of the last figures [ms]
    this.legend = new Legend((mode) => host.stops?.(mode) ?? mode.stops);
    this.play = button("play", "Play or pause (space)", () => this.toggle());
    this.play.id = "play";
    this.restart = button("restart", "Begin again (r)", () => host.send({ do: "restart" }));
    this.frame = button("frame", "One frame (.)", () => host.send({ do: "frame" }));
    this.record = button("record", "Record the frames", () =>
      host.send({ do: "record", on: !this.record.classList.contains("on") }),
    );
    this.record.classList.add("rec");
    this.speed = select(
      { title: "Simulated seconds in a second, at most", onchange: () => this.sendSpeed() },
      SPEEDS.map((factor) => [factor, `${factor}×`]),
    );
    this.speed.setAttribute("aria-label", "time scale");
    this.timeline = make("input", { type: "range", class: "timeline", min: 0, max: 1, step: 1, value: 0 });
    this.timeline.addEventListener("input", () =>
      host.send({ do: "seek", frame: Number(this.timeline.value) }),
    );
    this.timeline.setAttribute("aria-label", "timeline");
    this.space = make("span", { class: "space" });
    this.clock = make("span", { class: "clock" });
    this.panel = button(null, "Hide or show the panel (p)", () => host.togglePanel?.(), "panel");
    this.panel.hidden = !host.togglePanel;
    this.root.append(this.restart, this.play, this.frame, this.record, this.speed);
    this.root.append(this.timeline, this.space, this.clock, this.panel);
  }

  toggle() {
    this.host.send({ do: this.playing ? "pause" : "play" });
  }

  sendSpeed() {
    this.host.send({ do: "speed", factor: Number(this.speed.value) });
  }

  /**
   * @param {PlayerState} player
   * @param {boolean} live
   */
  show(player, live) {
    this.playing = player.playing;
    this.play.replaceChildren(icon(player.playing ? "pause" : "play"));
    this.play.classList.toggle("on", player.playing);
    this.record.hidden = !live;
    this.record.classList.toggle("on", player.recording);
    const known = [...this.speed.options].some((option) => Number(option.value) === player.speed);
    if (!known) this.speed.append(make("option", { value: player.speed }, `${player.speed}×`));
    this.speed.value = String(player.speed);
    this.timeline.hidden = player.frames === 0;
    this.space.hidden = player.frames !== 0;
    this.timeline.max = String(Math.max(0, player.frames - 1));
  }

  /** @param {BarState} state */
  showState(state) {
    this.updates.add();
    if (document.activeElement !== this.timeline || this.playing) this.timeline.value = String(state.frame);
    const of = this.duration ? ` of ${short(this.duration)}` : "";
    this.clock.textContent = `${state.time.toFixed(3)}${of} s · ${state.frame}`;
    this.clock.classList.toggle("over", this.duration > 0 && state.time > this.duration);
    this.state = state;
    this.legend.show(
      state,
      this.host.scene?.modes.find((m) => m.name === state.mode),
    );
  }

  /** Show the figures, four times a second. */
  tick() {
    const now = performance.now();
    if (!this.state || now - this.shown < 250) return;
    this.shown = now;
    const { n, facts } = this.state;
    this.legend.count(this.state);
    /** @type {[string, string][]} */
    const lines = [
      [this.pictures.text(), "pictures/s"],
      [this.updates.text(), "updates/s"],
      [n.toLocaleString("en"), "particles"],
    ];
    if (facts.steps !== undefined) {
      lines.push([facts.steps.toLocaleString("en"), "steps"]);
      lines.push([`${short((facts.dt ?? 0) * 1e3)} ms`, `step, bound by ${facts.bound || "nothing yet"}`]);
    }
    if (facts.pace) lines.push([`${short(facts.pace)}×`, "real time"]);
    for (const [name, value] of Object.entries(facts.keyed ?? {}))
      lines.push([value.map(short).join(", "), name]);
    const box = byId("figures");
    box.replaceChildren(...lines.map(([value, name]) => make("div", {}, make("b", {}, value), ` ${name}`)));
    this.showStages(box, Object.entries(facts.stages ?? {}));
    box.hidden = false;
  }

  /**
   * @param {HTMLElement} box
   * @param {[string, number][]} stages name and share
   */
  showStages(box, stages) {
    if (!stages.length) return;
    const bar = make("div", { class: "stages" });
    const names = make("div");
    const all = [...stages, /** @type {[string, number]} */ (["rest", Math.max(0, 1 - sum(stages))])];
    const percent = percents(all.map(([, share]) => share));
    all.forEach(([name, share], i) => {
      const color = i < stages.length ? STAGE_COLORS[i % STAGE_COLORS.length] : REST_COLOR;
      const part = make("span");
      part.style.width = `${100 * share}%`;
      part.style.background = color;
      bar.append(part);
      const text = make("span", {}, `${name} ${percent[i]} % `);
      text.style.color = color;
      if (percent[i]) names.append(text);
    });
    box.append(bar, names);
  }
}

/** @param {[string, number][]} stages */
function sum(stages) {
  return stages.reduce((total, [, share]) => total + share, 0);
}

/**
 * Round shares of a whole to percent so that they add up: the largest remainders are rounded up.
 * @param {number[]} shares
 */
export function percents(shares) {
  const whole = Math.max(
    1e-9,
    shares.reduce((a, b) => a + b, 0),
  );
  const exact = shares.map((share) => (100 * share) / whole);
  const found = exact.map(Math.floor);
  const order = exact.map((value, i) => [value - found[i], i]).sort((a, b) => b[0] - a[0]);
  const lacking = 100 - found.reduce((a, b) => a + b, 0);
  for (let k = 0; k < lacking; k++) found[order[k % order.length][1]] += 1;
  return found;
}
