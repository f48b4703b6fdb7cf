// Pull a body that hangs on a joint, or a robot's part, by a spring through the engine.

/** @import { PullCommand } from "../commands.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @import { Triangles } from "../draw/stage.js" */
/** @import { App } from "../main.js" */

import { R, V } from "../draw/math.js";
import { lineTriangles } from "../draw/overlays.js";

const COLOR = /** @type {Vec3} */ ([1.0, 0.75, 0.3]);
const RENEW = 200; // ms after which a pointer that rests says that it still holds

export class Pull {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {{ last: PullCommand, depth: number, sent: number } | null} */
    this.held = null;
  }

  /** @param {string} name */
  pose(name) {
    const i = this.app.scene?.solids.findIndex((solid) => solid.name === name) ?? -1;
    return i < 0 ? null : this.app.stage.poseOf(i);
  }

  /**
   * Take hold of a solid at a point of its surface.
   * @param {string} name
   * @param {Vec3} point [m]
   */
  begin(name, point) {
    const { camera } = this.app;
    const pose = this.pose(name);
    if (!pose) return false;
    const away = V.sub(point, pose.place);
    const grip = /** @type {Vec3} */ ([0, 1, 2].map((k) => V.dot(R.column(pose.turn, k), away)));
    const depth = V.dot(V.sub(point, camera.eye), camera.forward);
    this.held = { last: { do: "pull", name, grip, target: point, done: false }, depth, sent: 0 };
    this.send();
    return true;
  }

  /**
   * Pull towards the pointer, in the depth where it took hold.
   * @param {number} x share of the picture
   * @param {number} y
   */
  move(x, y) {
    const { held } = this;
    if (!held) return;
    const { camera } = this.app;
    const ray = camera.ray(x, y);
    held.last.target = V.mad(camera.eye, ray, held.depth / Math.max(V.dot(ray, camera.forward), 0.05));
    this.send();
  }

  send() {
    if (!this.held) return;
    this.held.sent = performance.now();
    this.app.send(this.held.last);
  }

  end() {
    if (this.held) this.app.send({ ...this.held.last, done: true });
    this.held = null;
    this.app.redraw();
  }

  tick() {
    if (this.held && performance.now() - this.held.sent > RENEW) this.send();
  }

  /** The spring. @returns {Triangles[]} */
  triangles() {
    const pose = this.held && this.pose(this.held.last.name);
    if (!this.held || !pose) return [];
    const { grip, target } = this.held.last;
    const from = grip.reduce((at, g, k) => V.mad(at, R.column(pose.turn, k), g), pose.place);
    const { eye, focal } = this.app.camera;
    return [{ color: COLOR, points: lineTriangles(from, target, eye, 1 / focal) }];
  }
}
