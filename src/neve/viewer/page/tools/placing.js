// Something new before it is there: a ghost of its box on the surface, until a click or Enter sets it down.

/** @import { Addable } from "../protocol.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @import { Triangles } from "../draw/stage.js" */
/** @import { App } from "../main.js" */

import { boxTriangles } from "../draw/overlays.js";
import { say } from "../controls/dom.js";

/** @type {Vec3} */
const GHOST = [0.45, 0.75, 1.0];

export class Placing {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {{ kind: string, what: Addable, at: Vec3 } | null} */
    this.ghost = null;
  }

  /**
   * Show a ghost under the view's centre.
   * @param {string} kind list of the scene
   * @param {Addable} what
   */
  begin(kind, what) {
    this.ghost = { kind, what, at: this.app.middle() };
    say(`click where the ${what.shape.replace(/^\w+:/, "")} is to stand, or press Enter; Esc: not at all`);
    this.app.canvas.focus();
    this.app.redraw();
  }

  /**
   * Take the ghost to the surface under the pointer.
   * @param {number} x share of the picture
   * @param {number} y
   */
  move(x, y) {
    if (!this.ghost) return;
    this.ghost.at = this.app.tools.hit(x, y).point;
    this.app.redraw();
  }

  /** Set it down where the ghost is. */
  finish() {
    const ghost = this.ghost;
    if (!ghost) return;
    this.app.send({ do: "add", kind: ghost.kind, shape: ghost.what.shape, at: ghost.at });
    this.cancel();
  }

  cancel() {
    this.ghost = null;
    this.app.redraw();
  }

  /** @returns {Triangles[]} */
  triangles() {
    if (!this.ghost) return [];
    const [x, y, z] = this.ghost.at;
    const half = this.ghost.what.half;
    const flat = 0.15 * this.app.camera.distance;
    /** @type {Vec3} */
    const size = half.some(Boolean) ? half : [2 * flat, 2 * flat, 0.005 * flat];
    return [{ color: GHOST, alpha: 0.4, points: boxTriangles([x, y, z + size[2]], size) }];
  }
}
