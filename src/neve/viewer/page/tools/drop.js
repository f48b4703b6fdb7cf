// Files that are dropped on the page: a scene, which is played, or a mesh or a height map, which is set down.

/** @import { Addable } from "../protocol.js" */
/** @import { App } from "../main.js" */

import { say } from "../controls/dom.js";

const PIECE = 11_250; // bytes; 15,000 letters of base64
const MOST = 24 * 2 ** 20; // bytes

export class Drop {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.kind = "colliders"; // list of the scene to which a mesh is added
    window.addEventListener("dragover", (event) => {
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    for (const kind of ["dragleave", "drop"])
      window.addEventListener(kind, () => document.body.classList.remove("dropping"));
    window.addEventListener("drop", (event) => {
      event.preventDefault();
      this.kind = event.shiftKey ? "sources" : "colliders";
      const files = [...(event.dataTransfer?.files ?? [])];
      if (!files.length) say("what was dropped is no file", true);
      void this.send(files);
    });
  }

  /**
   * Send files piece by piece, a scene last: it may name the others.
   * @param {File[]} files
   */
  async send(files) {
    const isScene = (/** @type {File} */ file) => file.name.toLowerCase().endsWith(".toml");
    for (const file of [...files.filter((f) => !isScene(f)), ...files.filter(isScene)]) {
      if (file.size > MOST || file.size === 0) {
        say(`${file.name} has ${file.size} bytes; a file that is dropped has 1 to ${MOST}`, true, 9);
        continue;
      }
      const bytes = await contentOf(file);
      if (!bytes) {
        say(`${file.name} cannot be read: drop files, no folder`, true, 9);
        continue;
      }
      for (let at = 0; at < bytes.length; at += PIECE) {
        const data = btoa(String.fromCharCode(...bytes.subarray(at, at + PIECE)));
        this.app.send({ do: "piece", name: file.name.slice(-200), at, of: bytes.length, data });
      }
    }
  }

  /** @param {Addable} what a mesh or a height map that has arrived */
  offer(what) {
    // No snow has the shape of the ground.
    this.app.placing.begin(what.shape.startsWith("terrain:") ? "colliders" : this.kind, what);
  }
}

/**
 * Return the bytes of a file; null for what is none, such as a folder.
 * @param {File} file
 */
async function contentOf(file) {
  try {
    return new Uint8Array(await file.arrayBuffer());
  } catch {
    return null;
  }
}
