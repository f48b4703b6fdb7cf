// Measure: the distance between two points of the surface.

/** @import { Vec3 } from "../draw/math.js" */
/** @import { Triangles } from "../draw/stage.js" */
/** @import { App } from "../main.js" */

import { V } from "../draw/math.js";
import { lineTriangles } from "../draw/overlays.js";
import { short } from "../controls/dom.js";
import { numbers } from "./probe.js";

/** @type {Vec3} */
const LINE = [1.0, 0.86, 0.35];

export class Measure {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {Vec3[]} */
    this.ends = [];
    this.fixed = false; // both ends were clicked
  }

  /** @param {Vec3} point */
  click(point) {
    if (this.ends.length < 2 || this.fixed) {
      this.ends = [point, point];
      this.fixed = false;
    } else {
      this.ends[1] = point;
      this.fixed = true;
    }
  }

  /** @param {Vec3} point */
  move(point) {
    if (this.ends.length === 2 && !this.fixed) this.ends[1] = point;
  }

  cancel() {
    this.ends = [];
    this.fixed = false;
  }

  /** The distance as text; empty without two ends. */
  text() {
    if (this.ends.length < 2) return "";
    const way = V.sub(this.ends[1], this.ends[0]);
    return `${short(V.length(way))} m (${numbers(way)})`;
  }

  /** @returns {Triangles[]} */
  triangles() {
    if (this.ends.length < 2) return [];
    const { eye, focal } = this.app.camera;
    return [{ color: LINE, points: lineTriangles(this.ends[0], this.ends[1], eye, 1 / focal) }];
  }
}
