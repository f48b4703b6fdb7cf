// The gizmo: three arrows to move a solid and three rings to turn it, of the same size on the screen everywhere.

/** @import { Solid } from "../protocol.js" */
/** @import { Rotation, Vec3 } from "../draw/math.js" */
/** @import { Pose, Triangles } from "../draw/stage.js" */
/** @import { App } from "../main.js" */
/** @typedef {{ kind: "move" | "turn" | "slide", axis: number }} Part slide: along the ground */
/** @typedef {number | Vec3} Grip a length along the axis, an angle, or a point of the ground */
/**
 * @typedef {object} Drag
 * @property {Part} part
 * @property {Pose} start
 * @property {Grip} from
 * @property {Vec3} position
 * @property {Rotation | null} turned
 */

import { R, V } from "../draw/math.js";

/** @type {Vec3[]} */
const AXES = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
/** @type {Vec3[]} */
const AXIS_COLORS = [
  [0.92, 0.33, 0.3],
  [0.42, 0.8, 0.36],
  [0.33, 0.56, 0.98],
];
/** @type {Vec3} */
const BRIGHT = [1.0, 0.86, 0.35];

export class Gizmo {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {Part | null} */
    this.hover = null;
    /** @type {Drag | null} */
    this.drag = null;
  }

  /**
   * The chosen solid, and where it is now.
   * @returns {{ solid: Solid, pose: Pose } | null}
   */
  target() {
    const { scene, selected, stage } = this.app;
    if (!scene?.live || !selected) return null;
    const i = scene.solids.findIndex((solid) => solid.name === selected);
    const pose = i < 0 ? null : stage.poseOf(i);
    return pose && { solid: scene.solids[i], pose };
  }

  /**
   * Length of an arrow at a place [m].
   * @param {Vec3} place
   */
  size(place) {
    const camera = this.app.camera;
    const depth = V.dot(V.sub(place, camera.eye), camera.forward);
    return Math.max(0.16 * depth * camera.tan[1], 1e-4);
  }

  /** @returns {Vec3 | null} */
  place() {
    return this.drag ? this.drag.position : (this.target()?.pose.place ?? null);
  }

  /**
   * @param {"move" | "turn"} kind
   * @param {number} axis
   */
  isBright(kind, axis) {
    const part = this.drag?.part ?? this.hover;
    return part?.kind === kind && part.axis === axis;
  }

  /** @returns {Triangles[]} */
  triangles() {
    const place = this.place();
    if (!place) return [];
    const size = this.size(place);
    /** @type {Triangles[]} */
    const found = [];
    AXES.forEach((axis, k) => {
      const color = this.isBright("move", k) ? BRIGHT : AXIS_COLORS[k];
      found.push(...this.arrow(place, axis, size).map((points) => ({ color, points })));
      if (!this.canTurn()) return;
      const ringColor = this.isBright("turn", k) ? BRIGHT : V.scale(AXIS_COLORS[k], 0.8);
      found.push({ color: ringColor, points: this.ring(place, k, size) });
    });
    return found;
  }

  /**
   * Shaft and head of an arrow.
   * @param {Vec3} place
   * @param {Vec3} axis
   * @param {number} size
   * @returns {Vec3[][]}
   */
  arrow(place, axis, size) {
    const side = V.unit(V.cross(axis, this.app.camera.forward));
    const from = V.mad(place, axis, 0.12 * size);
    const tip = V.mad(place, axis, size);
    const half = V.scale(side, 0.018 * size);
    const [a, b, c, d] = [V.add(from, half), V.sub(from, half), V.add(tip, half), V.sub(tip, half)];
    const head = [
      V.mad(tip, side, 0.07 * size),
      V.mad(tip, side, -0.07 * size),
      V.mad(tip, axis, 0.2 * size),
    ];
    return [[a, b, c, c, b, d], head];
  }

  canTurn() {
    const target = this.target();
    return Boolean(target && !["plane", "sphere", "terrain"].includes(target.solid.shape));
  }

  /**
   * The half of a ring that faces the eye, as a band.
   * @param {Vec3} place
   * @param {number} k
   * @param {number} size
   */
  ring(place, k, size) {
    /** @type {Vec3[]} */
    const points = [];
    const a = AXES[(k + 1) % 3];
    const b = AXES[(k + 2) % 3];
    const back = V.unit(V.sub(this.app.camera.eye, place));
    /** @type {Vec3[] | null} */
    let last = null;
    for (let i = 0; i <= 64; i++) {
      const t = (i / 64) * 2 * Math.PI;
      const out = V.add(V.scale(a, Math.cos(t)), V.scale(b, Math.sin(t)));
      const faces = V.dot(out, back) > -0.05;
      /** @type {Vec3[] | null} */
      const pair = faces ? [V.mad(place, out, 0.83 * size), V.mad(place, out, 0.86 * size)] : null;
      if (pair && last) points.push(last[0], last[1], pair[0], pair[0], last[1], pair[1]);
      last = pair;
    }
    return points;
  }

  /**
   * Return the part under the pointer.
   * @param {number} x share of the picture
   * @param {number} y
   * @returns {Part | null}
   */
  pick(x, y) {
    const place = this.target()?.pose.place;
    if (!place) return null;
    const camera = this.app.camera;
    const size = this.size(place);
    const aspect = camera.width / camera.height;
    /** @type {Part | null} */
    let best = null;
    let least = 0.022;
    /** @param {Vec3} point @param {Part} part @param {number} handicap */
    const offer = (point, part, handicap = 0) => {
      const [a, b, depth] = camera.project(point);
      const far = depth > 0 ? Math.hypot((a - x) * aspect, b - y) + handicap : 9;
      if (far >= least) return;
      least = far;
      best = part;
    };
    AXES.forEach((axis, k) => {
      for (let i = 2; i <= 12; i++) offer(V.mad(place, axis, (size * i) / 10), { kind: "move", axis: k });
      if (!this.canTurn()) return;
      const points = this.ring(place, k, size);
      for (let i = 0; i < points.length; i += 6) offer(points[i], { kind: "turn", axis: k }, 0.004);
    });
    return best;
  }

  /**
   * Begin to drag.
   * @param {Part} part
   * @param {number} x
   * @param {number} y
   * @returns {boolean} whether there is a solid to drag
   */
  begin(part, x, y) {
    const start = this.target()?.pose;
    if (!start) return false;
    const from = this.grip(part, start.place, x, y);
    this.drag = { part, start, from, position: start.place, turned: null };
    return true;
  }

  /**
   * Return what the pointer means for a part.
   * @param {Part} part
   * @param {Vec3} place
   * @param {number} x
   * @param {number} y
   * @returns {Grip}
   */
  grip(part, place, x, y) {
    const camera = this.app.camera;
    const ray = camera.ray(x, y);
    const axis = AXES[part.axis];
    if (part.kind === "move") {
      const w = V.sub(camera.eye, place);
      const b = V.dot(ray, axis);
      return (V.dot(axis, w) - b * V.dot(ray, w)) / Math.max(1 - b * b, 1e-6);
    }
    const down = V.dot(ray, axis);
    const t = V.dot(V.sub(place, camera.eye), axis) / (Math.abs(down) > 1e-4 ? down : 1e-4);
    const hit = V.sub(V.mad(camera.eye, ray, t), place);
    if (part.kind === "slide") return hit;
    return Math.atan2(V.dot(hit, AXES[(part.axis + 2) % 3]), V.dot(hit, AXES[(part.axis + 1) % 3]));
  }

  /** End a drag where the solid is now. */
  release() {
    const { drag } = this;
    if (!drag) return;
    const rotation = drag.turned && R.vector(drag.turned);
    this.app.send({ do: "move", name: this.app.selected, position: drag.position, rotation, done: true });
    this.drag = null;
  }

  /**
   * Drag to where the pointer is.
   * @param {number} x
   * @param {number} y
   * @param {boolean} done
   */
  move(x, y, done = false) {
    const drag = this.drag;
    if (!drag) return;
    const { part, start, from } = drag;
    const now = this.grip(part, start.place, x, y);
    const axis = AXES[part.axis];
    if (typeof now !== "number" && typeof from !== "number")
      drag.position = V.add(start.place, V.sub(now, from));
    else if (typeof now === "number" && typeof from === "number") {
      if (part.kind === "move") drag.position = V.mad(start.place, axis, now - from);
      else drag.turned = R.times(R.about(axis, now - from), start.turn);
    }
    const rotation = drag.turned && R.vector(drag.turned);
    this.app.send({ do: "move", name: this.app.selected, position: drag.position, rotation, done });
    if (done) this.drag = null;
  }
}
