"use strict";
// The bar below: play, pace, timeline and clock; and the figures and the legend in the corners.

const STAGE_COLORS = { bodies: "#c08fd8", stress: "#8fb8de", sort: "#6c8fb0", p2g: "#4f9dd8", grid: "#9fd0a8", g2p: "#d8b25a", contact: "#d8805a" };

class Bar {
  constructor(app) {
    this.app = app;
    this.root = document.getElementById("bar");
    this.playing = false;
    this.drawn = [];
    this.updates = [];
    this.play = button("play", "Play or pause (space)", () => this.toggle());
    this.play.id = "play";
    this.restart = button("restart", "Begin anew (r)", () => app.send({ do: "restart" }));
    this.frame = button("frame", "One frame (.)", () => app.send({ do: "frame" }));
    this.record = button("record", "Record the frames", () => app.send({ do: "record", on: !this.record.classList.contains("on") }));
    this.record.classList.add("rec");
    this.speed = make("select", { title: "Simulated seconds in a second, at most", onchange: () =>
      app.send({ do: "speed", factor: Number(this.speed.value) }) });
    for (const factor of [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 4]) this.speed.append(make("option", { value: factor }, `${factor}×`));
    this.speed.setAttribute("aria-label", "time scale");
    this.timeline = make("input", { type: "range", class: "timeline", min: 0, max: 1, step: 1, value: 0, oninput: () =>
      app.send({ do: "seek", frame: Number(this.timeline.value) }) });
    this.timeline.setAttribute("aria-label", "timeline");
    this.space = make("span", { class: "space" });
    this.clock = make("span", { class: "clock" });
    this.panel = button(null, "Hide or show the panel (p)", () => app.togglePanel(), "panel");
    this.panel.hidden = !app.togglePanel;
    this.root.append(this.restart, this.play, this.frame, this.record, this.speed, this.timeline, this.space, this.clock, this.panel);
  }

  toggle() {
    this.app.send({ do: this.playing ? "pause" : "play" });
  }

  show(player, live) {
    this.playing = player.playing;
    this.play.replaceChildren(icon(player.playing ? "pause" : "play"));
    this.play.classList.toggle("on", player.playing);
    this.record.hidden = !live;
    this.record.classList.toggle("on", player.recording);
    const known = [...this.speed.options].some((o) => Number(o.value) === player.speed);
    if (!known) this.speed.append(make("option", { value: player.speed }, `${player.speed}×`));
    this.speed.value = player.speed;
    this.timeline.hidden = player.frames === 0;
    this.space.hidden = player.frames !== 0;
    this.timeline.max = Math.max(0, player.frames - 1);
  }

  // Tell of a moment.
  tell(moment) {
    this.updates.push(performance.now());
    if (document.activeElement !== this.timeline || this.playing) this.timeline.value = moment.frame;
    this.clock.textContent = `${moment.time.toFixed(3)} s · ${moment.frame}`;
    this.moment = moment;
    this.legend(moment);
  }

  tick() {
    const now = performance.now(), lately = (list) => {
      while (list.length > 2 && now - list[0] > 1500) list.shift();  // two tell how slow it is
      const [first, last] = [list[0], list[list.length - 1]];
      if (list.length < 2 || now - last > 2 * (last - first) + 1500) return "0";
      const rate = ((list.length - 1) * 1000) / Math.max(last - first, 1);
      return rate.toFixed(rate < 9.95 ? 1 : 0);
    };
    const m = this.moment, box = document.getElementById("figures");
    if (!m || (this.told && now - this.told < 250)) return;
    this.told = now;
    const f = m.facts, lines = [
      [lately(this.drawn), "pictures/s"], [lately(this.updates), "updates/s"],
      [m.n.toLocaleString("en"), "particles"],
    ];
    if (f.steps !== undefined) {
      lines.push([f.steps.toLocaleString("en"), "steps"], [`${short(f.dt * 1e3)} ms`, `step, bound by ${f.bound || "nothing yet"}`]);
      if (f.pace) lines.push([`${short(f.pace)}×`, "real time"]);
    }
    box.replaceChildren(...lines.map(([value, name]) => make("div", {}, make("b", {}, value), ` ${name}`)));
    if (f.stages && Object.keys(f.stages).length) {
      const bar = make("div", { class: "stages" }), names = make("div", {});
      for (const name in f.stages) {
        const part = make("span");
        part.style.width = `${100 * f.stages[name]}%`;
        part.style.background = STAGE_COLORS[name] || "#888";
        bar.append(part);
        const word = make("span", {}, `${name} ${Math.round(100 * f.stages[name])} % `);
        word.style.color = STAGE_COLORS[name] || "#aaa";
        if (f.stages[name] > 0.04) names.append(word);
      }
      box.append(bar, names);
    }
    box.hidden = false;
  }

  // The lines of a legend of names; of pieces there are too many.
  names(mode) {
    const line = (value, text) => {
      const dot = make("span", { class: "dot" });
      dot.style.background = `rgb(${nameColor(value)})`;
      return make("div", { class: "name" }, dot, text);
    };
    if (mode === "material") return this.app.scene.materials.map((text, i) => line(i, text));
    return [line(0, "powder"), make("div", { class: "name" }, "any other colour: a piece")];
  }

  legend(moment) {
    const root = document.getElementById("legend"), scene = this.app.scene;
    const entry = scene.modes && scene.modes.find((m) => m.name === moment.mode);
    root.hidden = !entry || moment.mode === "snow";
    if (root.hidden) return void (this.legendKey = "");
    const key = `${moment.mode} ${moment.limits} ${scene.materials}`;
    if (key === this.legendKey) return;
    this.legendKey = key;
    root.replaceChildren(make("div", {}, entry.label + (entry.unit && entry.unit !== "1" ? ` [${entry.unit}]` : "")));
    if (entry.classes) return void root.append(...this.names(moment.mode));
    const strip = make("canvas", { width: 220, height: 1 }), context = strip.getContext("2d"), stops = PALETTES[entry.palette];
    const fill = context.createLinearGradient(0, 0, 220, 0);
    stops.forEach((c, i) => fill.addColorStop(i / (stops.length - 1), `rgb(${c})`));
    context.fillStyle = fill;
    context.fillRect(0, 0, 220, 1);
    const [low, high] = moment.limits;
    root.append(strip, make("div", { class: "ends" }, make("span", {}, short(low)), make("span", {}, short(0.5 * (low + high))),
      make("span", {}, short(high))));
  }
}
