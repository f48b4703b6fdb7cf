// Other scenes and runs: those that come with Neve, and those in the served folders; and the link to one.

/** @import { LibraryEntry, SceneMessage } from "../protocol.js" */
/** @import { App } from "../main.js" */

import { inHash, withHash } from "../address.js";
import { make, select } from "./dom.js";

export class Library {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {LibraryEntry[]} */
    this.entries = [];
    this.wanted = inHash(location.hash, "scene");
    this.choice = select({ id: "scene-choice" }, []);
    this.choice.setAttribute("aria-label", "scene or run");
    this.choice.addEventListener("change", () => this.open(this.choice.value));
    this.choice.addEventListener("pointerdown", () => this.ask());
    this.choice.addEventListener("focus", () => this.ask());
    window.addEventListener("hashchange", () => {
      const name = inHash(location.hash, "scene");
      if (name && name !== app.scene?.name) app.send({ do: "open", scene: name });
    });
  }

  /** Ask what there is now. */
  ask() {
    this.app.send({ do: "library" });
  }

  /** @param {LibraryEntry[]} entries */
  hear(entries) {
    this.entries = entries;
    this.fill();
  }

  /** @param {string} name */
  open(name) {
    if (name) this.app.send({ do: "open", scene: name });
  }

  /**
   * Open at first what the address names; afterwards the address names what is open, if it can be opened by name.
   * @param {SceneMessage} scene
   */
  show(scene) {
    const wanted = this.wanted;
    this.wanted = "";
    this.fill();
    if (wanted && wanted !== scene.name) this.open(wanted);
    else if (inHash(location.hash, "scene") || scene.name in scene.presets)
      history.replaceState(null, "", withHash(location.hash, "scene", scene.name));
  }

  fill() {
    const { scene } = this.app;
    if (!scene) return;
    const { presets, name } = scene;
    const known = name in presets || this.entries.some((entry) => entry.name === name);
    /** @param {string} label @param {[string, string][]} names */
    const group = (label, names) =>
      names.length
        ? make(
            "optgroup",
            { label },
            ...names.map(([value, title]) => make("option", { value, title }, value)),
          )
        : null;
    /** @param {LibraryEntry["kind"]} kind @returns {[string, string][]} */
    const of = (kind) =>
      this.entries.filter((entry) => entry.kind === kind).map((entry) => [entry.name, entry.name]);
    const groups = [
      group("runs", of("run")),
      group("scenes", of("scene")),
      group("come with Neve", Object.entries(presets)),
    ];
    this.choice.replaceChildren(
      ...(known ? [] : [make("option", { value: "" }, name)]),
      ...groups.filter((g) => g !== null),
    );
    this.choice.value = known ? name : "";
  }
}
