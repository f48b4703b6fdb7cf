// What the pointer does: look around, throw, push, grab, move solids. The right button always looks around.

/** @import { TouchCommand } from "../commands.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @import { Triangles } from "../draw/stage.js" */
/** @import { App } from "../main.js" */
/** @import { Icon } from "../controls/dom.js" */
/** @typedef {{ last: TouchCommand, point: Vec3, depth: number, time: number }} Stroke of push or grab */
/**
 * @typedef {object} Held what happens while a button is held
 * @property {"turn" | "pan" | "pinch" | "move" | "pull" | "touch" | "none"} kind
 * @property {number} x of the pointer [px]
 * @property {number} y
 * @property {Stroke | null} stroke
 */

import { V } from "../draw/math.js";
import { ringTriangles } from "../draw/overlays.js";
import { button, byId, short } from "../controls/dom.js";
import { snowHit, solidHit } from "./hit.js";
import { capture, dragCamera, listenToWheel } from "./pointer.js";
import { placeText, showProbe, valueText } from "./probe.js";

const BALL_SPEED = 12; // m/s
const RING = /** @type {Vec3} */ ([0.55, 0.8, 1.0]);
const PROBING = 120; // ms between two looks for what is under the pointer
/** Tools that change nothing, for runs that are finished. */
const LOOKING = ["look", "measure"];
const REST = 90; // ms after which a pointer that does not move is said to rest

/** @type {Record<string, { icon: Icon, title: string }>} */
export const TOOLS = {
  look: { icon: "look", title: "Look: drag to turn, right button to pan, wheel to zoom (1)" },
  throw: { icon: "throw", title: "Throw a snowball where you click (2)" },
  push: { icon: "push", title: "Push snow: drag over it (3)" },
  grab: { icon: "grab", title: "Grab snow: hold and drag (4)" },
  move: { icon: "move", title: "Move solids: click one, drag its arrows (5)" },
  measure: { icon: "measure", title: "Measure: click two points (6)" },
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
    /** @type {Map<number, [number, number]>} where each pointer that touches is [px] */
    this.fingers = new Map();
    this.brush = 1; // radius of push, grab and ball, as a share of the usual one
    this.speed = BALL_SPEED;
    /** @type {[number, number] | null} where the pointer is over the picture, in shares of it */
    this.over = null;
    this.probed = 0; // clock of the last look for what is under the pointer [ms]
    /** @type {[number, number, number, number] | null} where a look waits that came too soon */
    this.later = null;
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
    canvas.addEventListener("pointerleave", (event) => this.leave(event));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    listenToWheel(canvas, app.camera, () => app.redraw());
  }

  /** @param {string} name */
  choose(name) {
    if (!LOOKING.includes(name) && this.app.scene && !this.app.scene.live) return;
    this.tool = name;
    for (const [key, made] of this.buttons) made.classList.toggle("on", key === name);
    if (name !== "move") this.app.select("");
    if (name !== "measure") this.app.measure.cancel();
    showProbe([], 0, 0);
    this.app.redraw();
    this.canvas.style.cursor = name === "look" ? "grab" : "crosshair";
  }

  /** @param {boolean} live */
  show(live) {
    for (const [name, made] of this.buttons) made.hidden = !live && !LOOKING.includes(name);
    if (!live && !LOOKING.includes(this.tool)) this.choose("look");
  }

  /**
   * Where the pointer is, in shares of the picture.
   * @param {MouseEvent} event
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
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.fingers.size > 1) {
      this.endStroke();
      this.held = { kind: "pinch", x: event.clientX, y: event.clientY, stroke: null };
      return;
    }
    const first = event.button === 0;
    /** @type {Held} */
    const held = { kind: "turn", x: event.clientX, y: event.clientY, stroke: null };
    this.held = held;
    if (first && (this.tool === "look" || event.altKey)) held.kind = event.shiftKey ? "pan" : "turn";
    else if (!first) held.kind = this.tool === "look" || event.button === 1 ? "pan" : "turn";
    else if (this.app.placing.ghost) this.setDown(held, x, y);
    else if (this.tool === "measure") {
      held.kind = "none";
      this.app.measure.click(this.hit(x, y).point);
      this.probed = 0;
      this.probe(x, y, event.clientX, event.clientY);
    } else if (this.tool === "throw") held.kind = this.throw(x, y);
    else if (this.tool === "move") held.kind = this.beginMove(x, y);
    else this.beginTouch(held, x, y);
  }

  /** @param {PointerEvent} event */
  moved(event) {
    const [x, y] = this.at(event);
    const held = this.held;
    this.over = [x, y];
    if (held?.kind === "pinch") {
      this.pinch(event);
      return;
    }
    if (!held) {
      this.app.placing.move(x, y);
      if (this.tool === "measure") this.app.measure.move(this.hit(x, y).point);
      this.probe(x, y, event.clientX, event.clientY);
      if (this.tool === "measure") this.app.redraw();
      else if (this.tool === "move") this.app.gizmo.hover = this.app.gizmo.pick(x, y);
      else if (!this.brushes() && !this.app.placing.ghost) return;
    } else {
      const [right, down] = [event.clientX - held.x, event.clientY - held.y];
      if (held.kind === "turn" || held.kind === "pan")
        dragCamera(this.app.camera, held.kind, right, down, this.canvas.clientHeight);
      else if (held.kind === "move") this.app.gizmo.move(x, y);
      else if (held.kind === "pull") this.app.pull.move(x, y);
      else if (held.stroke) this.touch(held.stroke, x, y);
      held.x = event.clientX;
      held.y = event.clientY;
    }
    this.app.redraw();
  }

  /** @param {PointerEvent} event */
  up(event) {
    this.fingers.delete(event.pointerId);
    const [x, y] = this.at(event);
    if (this.held?.kind === "move") this.app.gizmo.move(x, y, true);
    this.endStroke();
  }

  /** Let go of what is held. */
  endStroke() {
    const held = this.held;
    this.held = null;
    if (held?.kind === "move" && this.app.gizmo.drag) this.app.gizmo.release();
    if (held?.kind === "pull") this.app.pull.end();
    if (held?.stroke) this.app.send({ ...held.stroke.last, velocity: [0, 0, 0], done: true });
  }

  /** @param {PointerEvent} event */
  leave(event) {
    this.over = this.later = null;
    // A finger that is lifted leaves, too: the length that it has measured stays to be read.
    if (event.pointerType !== "touch" || this.tool !== "measure") showProbe([], 0, 0);
    this.app.redraw();
  }

  /**
   * Two fingers: apart to come closer, together to go away, both the same way to pan.
   * @param {PointerEvent} event
   */
  pinch(event) {
    const before = [...this.fingers.values()].slice(0, 2);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    const after = [...this.fingers.values()].slice(0, 2);
    if (after.length < 2) return;
    /** @param {[number, number][]} ends */
    const apart = ([a, b]) => Math.max(8, Math.hypot(a[0] - b[0], a[1] - b[1]));
    this.app.camera.zoom(apart(before) / apart(after));
    /** @param {0 | 1} k */
    const shift = (k) => 0.5 * (after[0][k] + after[1][k] - before[0][k] - before[1][k]);
    dragCamera(this.app.camera, "pan", shift(0), shift(1), this.canvas.clientHeight);
    this.app.redraw();
  }

  /**
   * With shift the wheel changes the brush, with alt the speed of a throw.
   * @param {WheelEvent} event
   */
  wheel(event) {
    if (!this.brushes() || (!event.shiftKey && !event.altKey)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    const by = Math.exp(-0.0015 * Math.max(-300, Math.min(300, event.deltaY || event.deltaX)));
    if (event.altKey) this.speed = Math.max(0.5, Math.min(60, this.speed * by));
    else this.brush = Math.max(0.2, Math.min(6, this.brush * by));
    this.probed = 0;
    const [x, y] = this.at(event);
    this.probe(x, y, event.clientX, event.clientY);
    this.app.redraw();
  }

  /** Whether the tool has a size. */
  brushes() {
    return ["throw", "push", "grab"].includes(this.tool);
  }

  /** Radius of the brush, or of the ball that is thrown [m]. */
  radius() {
    const { camera, scene } = this.app;
    const [cells, share] = this.tool === "throw" ? [2.5, 0.025] : [4, 0.045];
    return this.brush * Math.max(cells * (scene?.dx ?? 0), share * camera.distance);
  }

  /** The brush around the pointer. @returns {Triangles[]} */
  triangles() {
    if (!this.over || !this.brushes() || this.held?.kind === "turn") return [];
    const { camera } = this.app;
    const depth = this.held?.stroke?.depth ?? camera.distance;
    const ray = camera.ray(...this.over);
    const middle = V.mad(camera.eye, ray, depth / Math.max(V.dot(ray, camera.forward), 0.05));
    const points = ringTriangles(middle, this.radius(), camera.right, camera.up);
    return [{ color: RING, alpha: 0.9, points }];
  }

  /**
   * Say what is under the pointer, a few times a second.
   * @param {number} x
   * @param {number} y
   * @param {number} left [px]
   * @param {number} top
   */
  probe(x, y, left, top) {
    const now = performance.now();
    const { state, scene, placing, measure } = this.app;
    if (!state || !scene) return;
    this.later = now - this.probed < PROBING ? [x, y, left, top] : null;
    if (this.later) return;
    const { point, solid, particle } = this.hit(x, y);
    this.probed = performance.now() + 4 * (performance.now() - now); // a million particles take a while
    const lines = [];
    if (this.tool === "measure" && measure.text()) lines.push(measure.text());
    if (placing.ghost) lines.push(placeText(placing.ghost.at));
    else if (particle >= 0) {
      const value = valueText(
        state,
        scene.modes.find((m) => m.name === state.mode),
        particle,
      );
      if (value) lines.push(value);
      lines.push(placeText(point));
    } else if (solid) lines.push(solid, placeText(point));
    if (this.brushes()) lines.push(`radius ${short(this.radius())} m`);
    if (this.tool === "throw") lines.push(`${short(this.speed)} m/s`);
    showProbe(lines, left, top);
  }

  /**
   * Set down what is new.
   * @param {Held} held
   * @param {number} x
   * @param {number} y
   */
  setDown(held, x, y) {
    held.kind = "none";
    this.app.placing.move(x, y);
    this.app.placing.finish();
  }

  /**
   * Return the point of snow or of a solid under the pointer, and which; without any, one in the depth of the target.
   * @param {number} x
   * @param {number} y
   */
  hit(x, y) {
    const { camera, stage, state, scene } = this.app;
    const ray = camera.ray(x, y);
    const snow =
      state && scene
        ? snowHit(state, scene.spacing, camera.eye, ray, stage.clip)
        : { t: Infinity, particle: -1 };
    const solid = solidHit(stage, camera.eye, ray);
    const nothing = camera.distance / Math.max(V.dot(ray, camera.forward), 0.05);
    const t = Math.min(snow.t, solid.t);
    const point = V.mad(camera.eye, ray, t === Infinity ? nothing : t);
    return solid.t < snow.t
      ? { point, solid: solid.name, particle: -1 }
      : { point, solid: "", particle: snow.particle };
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
    this.app.send({ do: "throw", origin, direction, speed: this.speed, radius: this.radius() });
    return "turn";
  }

  /**
   * Take a part of the gizmo, or choose the solid under the pointer and slide it along the ground.
   * @param {number} x
   * @param {number} y
   * @returns {"turn" | "move" | "pull"}
   */
  beginMove(x, y) {
    const { app } = this;
    const part = app.gizmo.pick(x, y);
    if (part && app.gizmo.begin(part, x, y)) return "move";
    const { solid: name, point } = this.hit(x, y);
    app.select(name);
    const solid = app.scene?.solids.find((s) => s.name === name);
    if (!solid || solid.shape === "plane") return "turn";
    if (solid.pulled) return app.pull.begin(name, point) ? "pull" : "turn";
    return app.gizmo.begin({ kind: "slide", axis: 2 }, x, y) ? "move" : "turn";
  }

  /**
   * @param {Held} held
   * @param {number} x
   * @param {number} y
   */
  beginTouch(held, x, y) {
    const { camera } = this.app;
    const { point } = this.hit(x, y);
    const depth = V.dot(V.sub(point, camera.eye), camera.forward);
    const radius = this.radius();
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
    if (this.later) this.probe(...this.later);
    const stroke = this.held?.stroke;
    if (!stroke || performance.now() - stroke.time <= REST) return;
    stroke.time = performance.now();
    this.app.send({ ...stroke.last, point: stroke.point, velocity: [0, 0, 0] });
  }
}
