// What the pointer does: look around, throw, push, grab, move solids. The right button always looks around.

/** @import { TouchCommand } from "../protocol.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @import { App } from "../main.js" */
/** @import { Icon } from "./dom.js" */
/** @typedef {{ last: TouchCommand, point: Vec3, depth: number, time: number }} Stroke of push or grab */
/**
 * @typedef {object} Held what happens while a button is held
 * @property {"turn" | "pan" | "move" | "touch" | "none"} kind
 * @property {number} x of the pointer [px]
 * @property {number} y
 * @property {Stroke | null} stroke
 */

import { V } from "../draw/math.js";
import { button, byId } from "./dom.js";
import { snowHit, solidHit } from "./hit.js";
import { capture, dragCamera, listenToWheel } from "./pointer.js";

const BALL_SPEED = 12; // m/s
const REST = 90; // ms after which a pointer that does not move is said to rest

/** @type {Record<string, { icon: Icon, title: string }>} */
export const TOOLS = {
  look: { icon: "look", title: "Look: drag to turn, right button to pan, wheel to zoom (1)" },
  throw: { icon: "throw", title: "Throw a snowball where you click (2)" },
  push: { icon: "push", title: "Push snow: drag over it (3)" },
  grab: { icon: "grab", title: "Grab snow: hold and drag (4)" },
  move: { icon: "move", title: "Move solids: click one, drag its arrows (5)" },
};

export class Tools {
  /**
   * @param {App} app
   * @param {HTMLCanvasElement} canvas
   */
  constructor(app, canvas) {
    this.app = app;
    this.canvas = canvas;
    this.tool = "look";
    /** @type {Held | null} */
    this.held = null;
    /** @type {Map<string, HTMLButtonElement>} */
    this.buttons = new Map();
    for (const [name, tool] of Object.entries(TOOLS)) {
      const made = button(tool.icon, tool.title, () => this.choose(name));
      made.dataset.tool = name;
      this.buttons.set(name, made);
      byId("tools").append(made);
    }
    this.choose("look");
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => this.up(event));
    listenToWheel(canvas, app.camera, () => app.redraw());
  }

  /** @param {string} name */
  choose(name) {
    if (name !== "look" && this.app.scene && !this.app.scene.live) return;
    this.tool = name;
    for (const [key, made] of this.buttons) made.classList.toggle("on", key === name);
    if (name !== "move") this.app.select("");
    this.canvas.style.cursor = name === "look" ? "grab" : "crosshair";
  }

  /** @param {boolean} live */
  show(live) {
    byId("tools").hidden = !live;
    if (!live) this.choose("look");
  }

  /**
   * Where the pointer is, in shares of the picture.
   * @param {PointerEvent} event
   * @returns {[number, number]}
   */
  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  /** @param {PointerEvent} event */
  down(event) {
    this.canvas.focus();
    capture(this.canvas, event.pointerId);
    const [x, y] = this.at(event);
    const first = event.button === 0;
    /** @type {Held} */
    const held = { kind: "turn", x: event.clientX, y: event.clientY, stroke: null };
    this.held = held;
    if (first && (this.tool === "look" || event.altKey)) held.kind = event.shiftKey ? "pan" : "turn";
    else if (!first) held.kind = this.tool === "look" || event.button === 1 ? "pan" : "turn";
    else if (this.tool === "throw") held.kind = this.throw(x, y);
    else if (this.tool === "move") held.kind = this.beginMove(x, y);
    else this.beginTouch(held, x, y);
  }

  /** @param {PointerEvent} event */
  moved(event) {
    const [x, y] = this.at(event);
    const held = this.held;
    if (!held) {
      if (this.tool !== "move") return;
      this.app.gizmo.hover = this.app.gizmo.pick(x, y);
    } else {
      const [right, down] = [event.clientX - held.x, event.clientY - held.y];
      if (held.kind === "turn" || held.kind === "pan")
        dragCamera(this.app.camera, held.kind, right, down, this.canvas.clientHeight);
      else if (held.kind === "move") this.app.gizmo.move(x, y);
      else if (held.stroke) this.touch(held.stroke, x, y);
      held.x = event.clientX;
      held.y = event.clientY;
    }
    this.app.redraw();
  }

  /** @param {PointerEvent} event */
  up(event) {
    const held = this.held;
    this.held = null;
    if (!held) return;
    const [x, y] = this.at(event);
    if (held.kind === "move") this.app.gizmo.move(x, y, true);
    if (held.stroke) this.app.send({ ...held.stroke.last, velocity: [0, 0, 0], done: true });
  }

  /**
   * Return the point of snow or of a solid under the pointer; without any, one in the depth of the target.
   * @param {number} x
   * @param {number} y
   */
  hit(x, y) {
    const { camera, stage, state, scene } = this.app;
    const ray = camera.ray(x, y);
    const snow = state && scene ? snowHit(state, scene.spacing, camera.eye, ray) : Infinity;
    const solid = solidHit(stage, camera.eye, ray);
    const nothing = camera.distance / Math.max(V.dot(ray, camera.forward), 0.05);
    const t = Math.min(snow, solid.t);
    const point = V.mad(camera.eye, ray, t === Infinity ? nothing : t);
    return { point, solid: solid.t < snow ? solid.name : "" };
  }

  /**
   * @param {number} x
   * @param {number} y
   * @returns {"turn" | "none"}
   */
  throw(x, y) {
    const { camera, scene } = this.app;
    if (!scene) return "none";
    const ray = camera.ray(x, y);
    const ahead = V.mad(camera.eye, ray, 0.3 * camera.distance);
    const origin = V.mad(ahead, camera.up, -0.06 * camera.distance);
    const direction = V.unit(V.sub(V.mad(camera.eye, ray, camera.distance), origin));
    const radius = Math.max(2.5 * scene.dx, 0.025 * camera.distance);
    this.app.send({ do: "throw", origin, direction, speed: BALL_SPEED, radius });
    return "turn";
  }

  /**
   * Take a part of the gizmo, or choose the solid under the pointer and slide it along the ground.
   * @param {number} x
   * @param {number} y
   * @returns {"turn" | "move"}
   */
  beginMove(x, y) {
    const { app } = this;
    const part = app.gizmo.pick(x, y);
    if (part && app.gizmo.begin(part, x, y)) return "move";
    const name = this.hit(x, y).solid;
    app.select(name);
    const solid = app.scene?.solids.find((s) => s.name === name);
    if (!solid || solid.shape === "plane") return "turn";
    return app.gizmo.begin({ kind: "slide", axis: 2 }, x, y) ? "move" : "turn";
  }

  /**
   * @param {Held} held
   * @param {number} x
   * @param {number} y
   */
  beginTouch(held, x, y) {
    const { camera, scene } = this.app;
    const { point } = this.hit(x, y);
    const depth = V.dot(V.sub(point, camera.eye), camera.forward);
    const radius = Math.max(4 * (scene?.dx ?? 0), 0.045 * camera.distance);
    const tool = this.tool === "grab" ? "grab" : "push";
    held.kind = "touch";
    const last = /** @type {TouchCommand} */ ({
      do: "touch",
      tool,
      point,
      velocity: [0, 0, 0],
      radius,
      done: false,
    });
    held.stroke = { last, point, depth, time: performance.now() };
    this.touch(held.stroke, x, y);
  }

  /**
   * @param {Stroke} stroke
   * @param {number} x
   * @param {number} y
   */
  touch(stroke, x, y) {
    const camera = this.app.camera;
    const now = performance.now();
    const ray = camera.ray(x, y);
    const point = V.mad(camera.eye, ray, stroke.depth / Math.max(V.dot(ray, camera.forward), 0.05));
    const seconds = Math.max((now - stroke.time) / 1000, 0.008);
    const velocity = V.scale(V.sub(point, stroke.point), 1 / seconds);
    stroke.point = point;
    stroke.time = now;
    stroke.last = { ...stroke.last, point, velocity };
    this.app.send(stroke.last);
  }

  /** While a button is held and the pointer rests, say so. */
  tick() {
    const stroke = this.held?.stroke;
    if (!stroke || performance.now() - stroke.time <= REST) return;
    stroke.time = performance.now();
    this.app.send({ ...stroke.last, point: stroke.point, velocity: [0, 0, 0] });
  }
}
