// Put the page together.

/** @import { Command, Field, Message, ProgressMessage, SceneMessage } from "./protocol.js" */
/** @import { State } from "./draw/snow_cloud.js" */

import { Connection } from "./connection.js";
import { Bar } from "./controls/bar.js";
import { byId, make, say } from "./controls/dom.js";
import { Gizmo } from "./controls/gizmo.js";
import { Panel } from "./controls/panel.js";
import { TOOLS, Tools } from "./controls/tools.js";
import { OrbitCamera } from "./draw/camera.js";
import { Stage } from "./draw/stage.js";

export class App {
  constructor() {
    /** @type {HTMLCanvasElement} */
    this.canvas = byId("view");
    this.stage = new Stage(this.canvas);
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
    this.panel = new Panel(this);
    this.gizmo = new Gizmo(this);
    this.tools = new Tools(this, this.canvas);
    this.bar = new Bar(this);
    this.listenToKeys();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      say("the graphics card has let go of the page: reload it", true, 60);
    });
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
  }

  resize() {
    this.stage.resize();
    this.dirty = true;
  }

  loop() {
    const now = performance.now();
    const seconds = Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    if (now >= this.rest && this.connection.take()) this.dirty = true;
    if (this.camera.fly(seconds)) this.dirty = true;
    this.tools.tick();
    this.bar.tick();
    if (this.dirty && now >= this.rest && this.scene && this.state) {
      this.dirty = false;
      this.camera.update(this.canvas.width, this.canvas.height, this.covered());
      this.stage.draw(this.camera);
      if (this.selected) this.stage.drawOverlay(this.camera, this.gizmo.triangles());
      this.rest = performance.now() + 0.5 * this.stage.finish();
      this.bar.pictures.add();
      this.drawn += 1;
      document.body.dataset.drawn = String(this.drawn);
    }
    requestAnimationFrame(() => this.loop());
  }

  /** @param {State} state */
  take(state) {
    this.state = state;
    if (!this.scene) return;
    this.stage.show(state);
    this.bar.showState(state);
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
        break;
      case "refused":
        if (message.path) this.panel.refuse(message.path, message.sentence);
        else say(message.sentence, true, 9);
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
    this.stage.setScene(scene);
    this.panel.show(scene);
    this.tools.show(scene.live);
    this.bar.show(scene.player, scene.live);
    document.title = `${scene.name} · Neve`;
    if (this.state) this.take(this.state);
    this.dirty = true;
  }

  /** @param {boolean} open */
  showConnection(open) {
    if (open) {
      this.lostLine?.remove();
      this.lostLine = null;
      this.send({ do: "color_mode", mode: this.mode });
    } else this.lostLine ??= say("the connection to Neve is lost; trying again …", true, 1e6);
  }

  /** @param {string} mode */
  setMode(mode) {
    this.mode = mode;
    this.send({ do: "color_mode", mode });
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

  /** @param {Field} field */
  changed(field) {
    if (!field.live) say(`${field.path} acts when the scene begins again (r)`);
  }

  listenToKeys() {
    const { keys } = this.camera;
    window.addEventListener("keydown", (event) => {
      if (isTyping(event.target) || event.ctrlKey || event.metaKey) return;
      const key = event.key.toLowerCase();
      this.press(key, event);
      if (event.shiftKey) keys.add("shift");
      keys.add(key);
    });
    window.addEventListener("keyup", (event) => {
      keys.delete(event.key.toLowerCase());
      if (!event.shiftKey) keys.delete("shift");
    });
    window.addEventListener("blur", () => keys.clear());
  }

  /**
   * @param {string} key
   * @param {KeyboardEvent} event
   */
  press(key, event) {
    const tool = Object.keys(TOOLS)[Number(key) - 1];
    if (key === " ") {
      event.preventDefault();
      if (event.target instanceof HTMLElement) event.target.blur();
      this.bar.toggle();
    } else if (key === "r") this.send({ do: "restart" });
    else if (key === ".") this.send({ do: "frame" });
    else if (key === "h") this.goHome();
    else if (key === "p") this.togglePanel();
    else if (tool) this.tools.choose(tool);
    else if (key.startsWith("arrow")) event.preventDefault();
  }
}

/** @param {EventTarget | null} target */
function isTyping(target) {
  if (target instanceof HTMLInputElement) return target.type !== "range" && target.type !== "checkbox";
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;
}

try {
  // For the browser's console and the tests; the page itself does not use it.
  Object.assign(window, { neve: new App() });
} catch (error) {
  byId("cover").textContent = `Neve cannot draw here: ${error instanceof Error ? error.message : error}`;
  throw error;
}
