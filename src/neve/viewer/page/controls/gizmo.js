"use strict";
// The gizmo: three arrows to move a solid and three rings to turn it, as large on the screen wherever it is.

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const AXIS_COLORS = [[0.92, 0.33, 0.30], [0.42, 0.80, 0.36], [0.33, 0.56, 0.98]];
const BRIGHT = [1.0, 0.86, 0.35];

class Gizmo {
  constructor(app) {
    this.app = app;
    this.hover = null;
    this.drag = null;
  }

  // The chosen solid's place and turn now; null without one.
  target() {
    const scene = this.app.scene;
    if (!scene || !scene.live || !this.app.selected) return null;
    const i = scene.solids.findIndex((s) => s.name === this.app.selected);
    return i < 0 ? null : { solid: scene.solids[i], ...(this.app.stage.modelOf(i) || {}) };
  }

  size(place) {
    const depth = V.dot(V.sub(place, this.app.camera.eye), this.app.camera.forward);
    return Math.max(0.16 * depth * this.app.camera.tan[1], 1e-4);
  }

  place() {
    const target = this.target();
    return this.drag ? this.drag.position : target && target.place;
  }

  strips() {
    const place = this.place();
    if (!place) return [];
    const size = this.size(place), camera = this.app.camera, strips = [];
    const part = (kind, axis) => (this.drag || this.hover || {}).kind === kind && (this.drag || this.hover).axis === axis;
    AXES.forEach((axis, k) => {
      const color = part("move", k) ? BRIGHT : AXIS_COLORS[k], tip = V.mad(place, axis, size);
      const side = V.unit(V.cross(axis, camera.forward)), w = 0.018 * size, head = 0.2 * size;
      const quad = (a, b, wide) => {
        const s = V.scale(side, wide);
        return [V.add(a, s), V.sub(a, s), V.add(b, s), V.add(b, s), V.sub(a, s), V.sub(b, s)];
      };
      strips.push({ color, points: quad(V.mad(place, axis, 0.12 * size), tip, w) });
      strips.push({ color, points: [V.mad(tip, side, 0.07 * size), V.mad(tip, side, -0.07 * size), V.mad(tip, axis, head)] });
      if (this.canTurn()) strips.push({ color: part("turn", k) ? BRIGHT : V.scale(AXIS_COLORS[k], 0.8), points: this.ring(place, k, size) });
    });
    return strips;
  }

  canTurn() {
    const target = this.target();
    return Boolean(target && !["plane", "sphere", "terrain"].includes(target.solid.shape));
  }

  // The half of a ring that faces the eye, as a band.
  ring(place, k, size) {
    const points = [], a = AXES[(k + 1) % 3], b = AXES[(k + 2) % 3], back = V.unit(V.sub(this.app.camera.eye, place));
    let last = null;
    for (let i = 0; i <= 64; i++) {
      const t = (i / 64) * 2 * Math.PI, out = V.add(V.scale(a, Math.cos(t)), V.scale(b, Math.sin(t)));
      const pair = V.dot(out, back) > -0.05 ? [V.mad(place, out, 0.83 * size), V.mad(place, out, 0.86 * size)] : null;
      if (pair && last) points.push(last[0], last[1], pair[0], pair[0], last[1], pair[1]);
      last = pair;
    }
    return points;
  }

  // The part under the pointer: shares of the picture.
  pick(x, y) {
    const target = this.target();
    if (!target || !target.place) return null;
    const camera = this.app.camera, size = this.size(target.place), aspect = camera.width / camera.height;
    const far = (p) => {
      const [a, b, depth] = camera.project(p);
      return depth > 0 ? Math.hypot((a - x) * aspect, b - y) : 9;
    };
    let best = null, least = 0.022;
    AXES.forEach((axis, k) => {
      for (let i = 2; i <= 12; i++) {
        const d = far(V.mad(target.place, axis, (size * i) / 10));
        if (d < least) (least = d), (best = { kind: "move", axis: k });
      }
      if (!this.canTurn()) return;
      const points = this.ring(target.place, k, size);
      for (let i = 0; i < points.length; i += 6) {
        const d = far(points[i]) + 0.004;
        if (d < least) (least = d), (best = { kind: "turn", axis: k });
      }
    });
    return best;
  }

  // Begin to drag a part, or with no part the solid itself along the ground.
  begin(part, x, y) {
    const target = this.target();
    if (!target || !target.place) return false;
    this.drag = { ...part, start: target.place, position: target.place, turn: target.turn, turned: null, from: this.value(part, target.place, x, y) };
    return true;
  }

  // What the pointer means for a part: a length along the axis, an angle, or a point of the ground.
  value(part, place, x, y) {
    const camera = this.app.camera, ray = camera.ray(x, y), axis = AXES[part.axis] || [0, 0, 1];
    if (part.kind === "move") {
      const w = V.sub(camera.eye, place), b = V.dot(ray, axis), d = V.dot(ray, w), e = V.dot(axis, w);
      const t = (e - b * d) / Math.max(1 - b * b, 1e-6);
      return t;
    }
    const down = V.dot(ray, axis);
    const t = V.dot(V.sub(place, camera.eye), axis) / (Math.abs(down) > 1e-4 ? down : 1e-4);
    const hit = V.sub(V.mad(camera.eye, ray, t), place);
    if (part.kind === "slide") return hit;
    const a = AXES[(part.axis + 1) % 3], b = AXES[(part.axis + 2) % 3];
    return Math.atan2(V.dot(hit, b), V.dot(hit, a));
  }

  move(x, y, done = false) {
    const d = this.drag;
    if (!d) return;
    const now = this.value(d, d.start, x, y);
    const wish = { do: "move", name: this.app.selected, done };
    if (d.kind === "move") d.position = V.mad(d.start, AXES[d.axis], now - d.from);
    else if (d.kind === "slide") d.position = V.add(d.start, V.sub(now, d.from));
    else d.turned = R.times(R.about(AXES[d.axis], now - d.from), d.turn);
    if (d.turned) wish.rotation = R.vector(d.turned);
    this.app.send({ ...wish, position: d.position });
    if (done) this.drag = null;
  }
}
