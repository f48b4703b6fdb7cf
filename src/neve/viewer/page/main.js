// Put the page together.

/** @import { Command } from "./commands.js" */
/** @import { Message, Mode, ProgressMessage, SceneMessage } from "./protocol.js" */
/** @import { State } from "./draw/snow_cloud.js" */

import { Connection } from "./connection.js";
import { Bar } from "./controls/bar.js";
import { ColorsSection } from "./controls/colors_section.js";
import { byId, caption, make, say } from "./controls/dom.js";
import { Drop } from "./tools/drop.js";
import { Gizmo } from "./tools/gizmo.js";
import { Drive } from "./controls/drive.js";
import { Library } from "./controls/library.js";
import { Plots } from "./controls/plots.js";
import { Panel } from "./controls/panel.js";
import { listenToKeys } from "./controls/keys.js";
import { Measure } from "./tools/measure.js";
import { Placing } from "./tools/placing.js";
import { Pull } from "./tools/pull.js";
import { Tools } from "./tools/tools.js";
import { OrbitCamera } from "./draw/camera.js";
import { Stage } from "./draw/stage.js";
import { resolutionOf } from "./address.js";

const NARROW = 720; // px below which the panel is hidden at first

export class App {
  constructor() {
    /** @type {HTMLCanvasElement} */
    this.canvas = byId("view");
    this.stage = new Stage(this.canvas);
    this.stage.resolution = resolutionOf(location.hash);
    this.camera = new OrbitCamera();
    this.mode = "snow";
    this.selected = "";
    /** @type {SceneMessage | null} */
    this.scene = null;
    /** @type {State | null} */
    this.state = null;
    this.dirty = true;
    this.drawn = 0; // pictures
    /** @type {HTMLElement | null} */
    this.progressLine = null;
    /** @type {HTMLElement | null} */
    this.lostLine = null;
    /** @type {HTMLElement | null} */
    this.lostCard = null;
    this.colors = new ColorsSection(this);
    this.plots = new Plots(this);
    this.library = new Library(this);
    this.drive = new Drive(this);
    this.pull = new Pull(this);
    this.drop = new Drop(this);
    this.panel = new Panel(this);
    this.panel.root.hidden = window.innerWidth < NARROW;
    this.gizmo = new Gizmo(this);
    this.placing = new Placing(this);
    this.measure = new Measure(this);
    this.tools = new Tools(this, this.canvas);
    this.bar = new Bar(this);
    listenToKeys(this);
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.lostCard ??= say("the graphics card has let go of the page; waiting for it …", true, 600);
    });
    this.canvas.addEventListener("webglcontextrestored", () => this.restore());
    this.connection = new Connection({
      onState: (state) => this.take(state),
      onMessage: (message) => this.hear(message),
      onOpen: (open) => this.showConnection(open),
    });
    this.last = performance.now();
    this.rest = 0; // clock from which to draw again
    requestAnimationFrame(() => this.loop());
  }

  /** @param {Command} command */
  send(command) {
    this.connection.send(command);
  }

  redraw() {
    this.dirty = true;
    this.stage.detail.move(performance.now());
  }

  resize() {
    this.stage.resize();
    this.dirty = true;
  }

  loop() {
    const now = performance.now();
    const seconds = Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    const { detail } = this.stage;
    if (detail.due(now)) this.dirty = true;
    if (now >= this.rest && this.connection.take()) this.redraw();
    if (this.camera.fly(seconds)) this.redraw();
    this.tools.tick();
    this.pull.tick();
    this.drive.tick(seconds);
    this.bar.tick();
    this.plots.tick();
    if (this.dirty && now >= this.rest && this.scene && this.state) {
      this.dirty = false;
      this.camera.update(this.canvas.width, this.canvas.height, this.covered());
      this.stage.draw(this.camera);
      this.stage.drawOverlay(this.camera, this.overlay());
      this.rest = performance.now() + 0.5 * this.stage.finish();
      detail.learn(performance.now());
      this.bar.pictures.add();
      this.drawn += 1;
      document.body.dataset.drawn = String(this.drawn);
    }
    requestAnimationFrame(() => this.loop());
  }

  /** What is drawn over the picture. */
  overlay() {
    const figures = [...this.placing.triangles(), ...this.measure.triangles(), ...this.tools.triangles()];
    figures.push(...this.pull.triangles());
    return this.selected ? [...figures, ...this.gizmo.triangles()] : figures;
  }

  /** @param {State} state */
  take(state) {
    this.state = state;
    if (!this.scene) return;
    this.stage.show(state);
    this.bar.showState(state);
    this.plots.stale = true;
    document.body.dataset.time = String(state.time);
    document.body.dataset.particles = String(state.n);
    byId("cover").classList.add("gone");
  }

  /** @param {Message} message */
  hear(message) {
    switch (message.kind) {
      case "scene":
        this.setScene(message);
        break;
      case "player":
        this.bar.show(message, this.scene?.live ?? true);
        this.panel.showHistory(message);
        break;
      case "refused":
        if (message.path) this.panel.refuse(message.path, message.sentence);
        else say(message.sentence, true, 9);
        break;
      case "note":
        say(message.sentence, false, 9);
        break;
      case "figures":
        this.plots.hear(message);
        break;
      case "library":
        this.library.hear(message.entries);
        break;
      case "dropped":
        this.drop.offer(message.what);
        break;
      case "progress":
        this.showProgress(message);
        break;
      case "file":
        this.progressLine?.remove();
        this.panel.addFile(message);
        say(
          make("div", {}, "saved ", make("a", { href: message.url, target: "_blank" }, message.name)),
          false,
          12,
        );
        break;
    }
  }

  /** @param {ProgressMessage} message */
  showProgress({ what, done, of }) {
    const text = `${what}: ${done} of ${of}`;
    if (this.progressLine?.isConnected) this.progressLine.textContent = text;
    else this.progressLine = say(text, false, 600);
  }

  /** @param {SceneMessage} scene */
  setScene(scene) {
    const isOther = this.scene?.name !== scene.name;
    this.scene = scene;
    if (isOther) this.goHome();
    if (isOther && this.selected) this.select("");
    this.library.show(scene);
    this.stage.setScene(scene);
    for (const mode of scene.modes) this.stage.setPalette(mode.name, this.stops(mode));
    this.plots.show(scene);
    this.drive.show(scene);
    this.panel.show(scene);
    this.tools.show(scene.live);
    this.bar.duration = scene.live ? scene.duration : 0;
    this.bar.show(scene.player, scene.live);
    this.panel.showHistory(scene.player);
    document.title = `${scene.name} · Neve`;
    caption(scene.caption);
    if (this.state) this.take(this.state);
    this.dirty = true;
  }

  /** @param {boolean} open */
  showConnection(open) {
    if (open) {
      this.lostLine?.remove();
      this.lostLine = null;
      this.colors.send();
      if (this.plots.asked) this.plots.begin();
    } else this.lostLine ??= say("the connection to Neve is lost; trying again …", true, 1e6);
  }

  /** @param {string} mode */
  setMode(mode) {
    this.mode = mode;
    this.colors.send();
  }

  /** @param {Mode} mode */
  stops(mode) {
    return this.colors.stops(mode);
  }

  /** @param {number} size of a particle, 1 as in the film */
  setSize(size) {
    this.stage.size = size;
    this.redraw();
  }

  /** @param {number} quality */
  setQuality(quality) {
    this.stage.setQuality(quality);
    this.redraw();
  }

  /** @param {boolean} on */
  setSurface(on) {
    try {
      this.stage.setSurface(on);
    } catch (error) {
      say(`${error instanceof Error ? error.message : error}: the snow stays as grains`, true);
    }
    this.redraw();
  }

  /** @param {boolean} on whether flakes in the air are drawn */
  setFlakes(on) {
    this.stage.flakes = on;
    this.redraw();
  }

  /** @param {number} resolution */
  setResolution(resolution) {
    this.stage.resolution = resolution;
    this.resize();
  }

  goHome() {
    if (this.scene) this.camera.set(this.scene.camera);
    this.redraw();
  }

  /** @param {string} name one of the VIEWS */
  see(name) {
    const { snow } = this.stage;
    if (this.state) this.camera.see(name, snow.middle(), snow.ball[3]);
    this.redraw();
  }

  /** @param {string} name of a solid, or empty */
  select(name) {
    if (this.selected === name) return;
    this.selected = name;
    this.stage.selected = name;
    if (name && this.tools.tool === "move") this.panel.reveal(name);
    this.redraw();
  }

  /** Share of the width that the panel covers, where enough is left. */
  covered() {
    const { root } = this.panel;
    const width = this.canvas.clientWidth;
    return root.hidden || width < 900 ? 0 : (root.offsetWidth + 12) / width;
  }

  togglePanel() {
    this.panel.root.hidden = !this.panel.root.hidden;
    this.redraw();
  }

  /** The point in the middle of the view: of snow, of a solid, or the target. */
  middle() {
    return this.tools.hit(0.5 - 0.5 * this.camera.covered, 0.5).point;
  }

  /** Delete the chosen solid; a robot's part stands for its robot. */
  deleteSelected() {
    const name = this.selected.split(".").slice(0, 2).join(".");
    if (name && this.scene?.live) this.send({ do: "delete", name });
    this.select("");
  }

  /** Draw again what the graphics card has lost, and has room for now. */
  restore() {
    const { size, quality, clip, resolution, surface, flakes } = this.stage;
    this.stage = new Stage(this.canvas);
    Object.assign(this.stage, { size, quality, resolution, flakes, selected: this.selected });
    this.stage.setClip(clip);
    if (surface) this.setSurface(true);
    if (this.scene) this.setScene(this.scene);
    this.lostCard?.remove();
    this.lostCard = null;
    this.redraw();
  }
}

try {
  // For the browser's console and the tests; the page itself does not use it.
  Object.assign(window, { neve: new App() });
} catch (error) {
  byId("cover").textContent = `Neve cannot draw here: ${error instanceof Error ? error.message : error}`;
  throw error;
}
