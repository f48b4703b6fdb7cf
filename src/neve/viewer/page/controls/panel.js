// The panel: the scene's fields as the server tells them, and what can be done with the whole scene.

/** @import { Command } from "../commands.js" */
/** @import { FileMessage, PlayerState, SceneMessage, Section } from "../protocol.js" */
/** @import { App } from "../main.js" */
/** @import { Child } from "./dom.js" */

import { VIEWS } from "../draw/camera.js";
import { button, byId, make, say, select } from "./dom.js";
import { Fields } from "./fields.js";

/** @type {Record<string, string>} */
const KIND_NAMES = { sources: "snow", colliders: "collider", bodies: "body" };

/** @type {Record<string, [number, number]>} sizes of pictures and films [px]; 0: as the page */
const SIZES = {
  "as the page": [0, 0],
  "1280 × 720": [1280, 720],
  "1920 × 1080": [1920, 1080],
  "3840 × 2160": [3840, 2160],
};

export class Panel {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.root = byId("panel");
    this.open = new Set(["scene", "look", "snow"]);
    this.fields = new Fields(app);
    this.key = "";
    this.files = make("div", { class: "files" });
    /** @type {HTMLButtonElement | null} */
    this.undo = null;
    /** @type {HTMLButtonElement | null} */
    this.redo = null;
    this.pictureSize = "1920 × 1080";
  }

  /**
   * Build the panel for a scene, or only set the values if the fields are the same.
   * @param {SceneMessage} scene
   */
  show(scene) {
    const sections = scene.panel.map((s) => [s.path, s.title, s.can, s.fields.map((field) => field.path)]);
    const controls = scene.controls.map((control) => control.name);
    const key = JSON.stringify([scene.name, scene.live, sections, controls]);
    if (key === this.key) {
      for (const section of scene.panel) for (const field of section.fields) this.fields.update(field);
      return;
    }
    this.key = key;
    this.fields.clear();
    const top = this.root.scrollTop;
    const close = button(null, "Close the panel (p)", () => this.app.togglePanel(), "×");
    close.className = "close";
    this.root.replaceChildren(
      close,
      this.sceneSection(scene),
      this.lookSection(scene),
      this.plotsSection(),
      this.recordSection(scene),
    );
    if (scene.live) this.root.append(this.addSection(scene));
    if (scene.controls.length) this.root.append(this.fold("controls", "controls", this.app.drive.root));
    /** @type {Map<string, HTMLElement>} */
    const made = new Map();
    for (const section of scene.panel) {
      const details = this.section(section, scene.live);
      made.set(section.path, details);
      (made.get(section.parent) ?? this.root).append(details); // one that lies in another comes after it
    }
    this.root.scrollTop = top;
  }

  /**
   * @param {string} id
   * @param {string} title
   * @param {Child[]} content
   */
  fold(id, title, ...content) {
    const details = make("details", { open: this.open.has(id) }, make("summary", {}, title), ...content);
    details.dataset.section = id;
    details.addEventListener("toggle", () => (details.open ? this.open.add(id) : this.open.delete(id)));
    return details;
  }

  /**
   * @param {string} label
   * @param {Child[]} content
   */
  row(label, ...content) {
    return make(
      "div",
      { class: "row" },
      make("label", {}, label),
      make("div", { class: "value" }, ...content),
    );
  }

  /** @param {SceneMessage} scene */
  sceneSection(scene) {
    const { app } = this;
    const save = button(
      null,
      "Save the scene as TOML, with this camera",
      () => this.send("save"),
      "save scene",
    );
    this.undo = button("undo", "Take back (Ctrl Z)", () => app.send({ do: "undo" }));
    this.redo = button("redo", "Do again (Ctrl Y)", () => app.send({ do: "redo" }));
    this.undo.hidden = this.redo.hidden = !scene.live;
    const home = button("home", "Camera of the scene (h)", () => app.goHome());
    const views = Object.keys(VIEWS).map((name) =>
      button(null, `See the snow: ${name}`, () => app.see(name), name),
    );
    return this.fold(
      "scene",
      "scene",
      this.row("scene", app.library.choice),
      make("p", { class: "hint" }, scene.about || scene.name),
      make("div", { class: "buttons views" }, home, ...views),
      make("div", { class: "buttons" }, save, this.undo, this.redo),
    );
  }

  /** @param {PlayerState} player */
  showHistory({ undo, redo }) {
    if (!this.undo || !this.redo) return;
    this.undo.disabled = !undo;
    this.redo.disabled = !redo;
    this.undo.title = undo ? `Take back: ${undo} (Ctrl Z)` : "Nothing to take back";
    this.redo.title = redo ? `Do again: ${redo} (Ctrl Y)` : "Nothing to do again";
  }

  /** @param {SceneMessage} scene */
  lookSection(scene) {
    const { app } = this;
    const size = make("input", { type: "range", min: 0.4, max: 2.5, step: 0.05, value: app.stage.size });
    size.addEventListener("input", () => app.setSize(Number(size.value)));
    /** @type {[number, string][]} */
    const qualities = ["no shadows", "fast", "full"].map((text, i) => [i, text]);
    const quality = select(
      { id: "quality", onchange: () => app.setQuality(Number(quality.value)) },
      qualities,
    );
    quality.value = String(app.stage.quality);
    const surface = select({ id: "surface", onchange: () => app.setSurface(surface.value === "surface") }, [
      ["grains", "grains"],
      ["surface", "surface"],
    ]);
    surface.value = app.stage.surface ? "surface" : "grains";
    const flakes = select({ id: "flakes", onchange: () => app.setFlakes(flakes.value === "shown") }, [
      ["shown", "shown"],
      ["hidden", "hidden"],
    ]);
    flakes.value = app.stage.flakes ? "shown" : "hidden";
    const resolution = select(
      { id: "resolution", onchange: () => app.setResolution(Number(resolution.value)) },
      [
        [0, "usual"],
        ...[0.35, 0.5, 0.7, 1, 2].map(
          (share) => /** @type {[number, string]} */ ([share, `${100 * share} %`]),
        ),
      ],
    );
    resolution.value = String(app.stage.resolution);
    const colors = app.colors.rows(scene, (label, ...content) => this.row(label, ...content));
    const rows = [
      this.row("snow as", surface),
      ...colors,
      this.row("point size", size),
      this.row("shadows", quality),
      this.row("falling flakes", flakes),
      this.row("resolution", resolution),
    ];
    return this.fold("look", "look", ...rows);
  }

  plotsSection() {
    const { plots } = this.app;
    const details = this.fold("plots", "plots", plots.root);
    details.addEventListener("toggle", () => details.open && plots.begin());
    return details;
  }

  /** @param {SceneMessage} scene */
  recordSection(scene) {
    const hint = scene.live
      ? "Press record in the bar, play, and stop it; then make a film or a replay of it."
      : "Film and replay hold all frames of this run.";
    const picture = button(
      "camera",
      "Picture with this camera (PNG)",
      () => this.send("picture"),
      " picture",
    );
    const film = button("film", "Film with this camera (MP4)", () => this.send("film"), " film");
    const replay = button(
      null,
      "A page that plays by itself (HTML)",
      () => this.app.send({ do: "replay" }),
      "replay",
    );
    const onchange = () => (this.pictureSize = size.value);
    const size = select(
      { id: "picture-size", onchange },
      Object.keys(SIZES).map((name) => [name, name]),
    );
    size.value = this.pictureSize;
    const buttons = make("div", { class: "buttons" }, picture, film, replay);
    const content = [make("p", { class: "hint" }, hint), this.row("size", size), buttons, this.files];
    return this.fold("record", "record", ...content);
  }

  /**
   * Ask for a file that is made with the page's camera.
   * @param {"save" | "picture" | "film"} kind
   */
  send(kind) {
    const [width, height] = SIZES[this.pictureSize];
    this.app.send({ do: kind, camera: this.app.camera.toCommand(width, height) });
  }

  /** @param {SceneMessage} scene */
  addSection(scene) {
    const rows = Object.entries(scene.addable).map(([kind, shapes]) => {
      const shape = select(
        {},
        shapes.map((what, i) => [i, what.shape.replace(/^\w+:/, "")]),
      );
      shape.setAttribute("aria-label", `shape to add to ${kind}`);
      const title = `Add to ${kind}: a ghost shows where`;
      const command = () => this.app.placing.begin(kind, shapes[Number(shape.value)]);
      const add = button(null, title, command, "add");
      add.dataset.add = kind;
      return this.row(KIND_NAMES[kind] ?? kind, shape, add);
    });
    return this.fold("add", "add", ...rows);
  }

  /**
   * @param {Section} section
   * @param {boolean} live
   */
  section(section, live) {
    const rows = section.fields.map((field) => this.fields.row(field));
    const details = this.fold(
      section.path,
      section.title,
      make("p", { class: "hint" }, section.text),
      ...rows,
    );
    if (!live) return details;
    if (section.can) details.firstElementChild?.append(this.changeButton(section.can, section.path));
    if (!section.parent && section.path.includes("."))
      details.addEventListener("toggle", () => details.open && this.app.select(section.path));
    return details;
  }

  /**
   * @param {"add" | "delete"} can
   * @param {string} path
   */
  changeButton(can, path) {
    /** @type {Command} */
    const command = can === "add" ? { do: "enlarge", path } : { do: "delete", name: path };
    const change = make("button", { class: can, type: "button", title: `${can} ${path}` }, can);
    change.addEventListener("click", (event) => {
      event.preventDefault(); // the section does not fold
      this.open.add(path);
      this.app.send(command);
    });
    return change;
  }

  /**
   * Show why a value was refused, beside it if its row is there.
   * @param {string} path
   * @param {string} sentence
   */
  refuse(path, sentence) {
    if (!this.fields.refuse(path, sentence)) say(sentence, true);
  }

  /**
   * Point at the section of a solid, and open it.
   * @param {string} path
   */
  reveal(path) {
    const entry = path.split(".").slice(0, 2).join("."); // a robot's part lies in the robot
    const details = this.root.querySelector(`details[data-section="${CSS.escape(entry)}"]`);
    if (!(details instanceof HTMLDetailsElement)) return;
    details.open = true;
    details.scrollIntoView({ block: "nearest" });
  }

  /** @param {FileMessage} file */
  addFile(file) {
    const size =
      file.bytes > 1e6 ? `${(file.bytes / 1e6).toFixed(1)} MB` : `${Math.ceil(file.bytes / 1e3)} kB`;
    const link = make("a", { href: file.url, target: "_blank", title: file.place }, `${file.name} (${size})`);
    this.files.prepend(link);
  }
}
