"use strict";
// What the pointer does: look around, throw, push, grab, move solids. The right button always looks around.

const TOOLS = {
  look: ["look", "Look: drag to turn, right button to shift, wheel to zoom (1)"],
  throw: ["throw", "Throw a snowball where you click (2)"],
  push: ["push", "Push snow: drag over it (3)"],
  grab: ["grab", "Grab snow: hold and drag (4)"],
  move: ["move", "Move solids: click one, drag its arrows (5)"],
};

class Tools {
  constructor(app, canvas) {
    this.app = app, this.canvas = canvas;
    this.tool = "look";
    this.held = null;
    this.ballSpeed = 12;
    const nav = document.getElementById("tools");
    this.buttons = {};
    for (const name in TOOLS) {
      this.buttons[name] = button(TOOLS[name][0], TOOLS[name][1], () => this.choose(name));
      this.buttons[name].dataset.tool = name;
      nav.append(this.buttons[name]);
    }
    this.choose("look");
    canvas.addEventListener("pointerdown", (e) => this.down(e));
    canvas.addEventListener("pointermove", (e) => this.moved(e));
    canvas.addEventListener("pointerup", (e) => this.up(e));
    canvas.addEventListener("pointercancel", (e) => this.up(e));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      app.camera.zoom(Math.exp(0.0012 * Math.max(-300, Math.min(300, e.deltaY * (e.deltaMode ? 30 : 1)))));
      app.redraw();
    }, { passive: false });
  }

  live() {
    return Boolean(this.app.scene && this.app.scene.live);
  }

  choose(name) {
    if (name !== "look" && this.app.scene && !this.live()) return;
    this.tool = name;
    for (const key in this.buttons) this.buttons[key].classList.toggle("on", key === name);
    if (name !== "move") this.app.select("");
    this.canvas.style.cursor = name === "look" ? "grab" : "crosshair";
  }

  shown(live) {
    document.getElementById("tools").hidden = !live;
    if (!live) this.choose("look");
  }

  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  down(event) {
    this.canvas.focus();
    try { this.canvas.setPointerCapture(event.pointerId); } catch { /* the pointer has gone already */ }
    const [x, y] = this.at(event);
    const turn = event.button === 0 && (this.tool === "look" || event.altKey), second = event.button !== 0 || event.shiftKey;
    this.held = { x: event.clientX, y: event.clientY, kind: "turn", time: performance.now() };
    if (turn) this.held.kind = second ? "pan" : "turn";
    else if (event.button !== 0) this.held.kind = this.tool === "look" || event.button === 1 ? "pan" : "turn";
    else if (this.tool === "throw") this.throw(x, y);
    else if (this.tool === "move") this.beginMove(x, y);
    else this.beginTouch(x, y);
  }

  moved(event) {
    const [x, y] = this.at(event);
    if (!this.held) {
      if (this.tool === "move") {
        this.app.gizmo.hover = this.app.gizmo.pick(x, y);
        this.app.redraw();
      }
      return;
    }
    const dx = event.clientX - this.held.x, dy = event.clientY - this.held.y, height = this.canvas.clientHeight;
    if (this.held.kind === "turn") this.app.camera.turn((4 * dx) / height, (4 * dy) / height);
    else if (this.held.kind === "pan") this.app.camera.pan((2 * dx) / height, (2 * dy) / height);
    else if (this.held.kind === "move") this.app.gizmo.move(x, y);
    else if (this.held.kind === "touch") this.touch(x, y);
    this.held.x = event.clientX, this.held.y = event.clientY;
    this.app.redraw();
  }

  up(event) {
    const held = this.held;
    this.held = null;
    if (!held) return;
    const [x, y] = this.at(event);
    if (held.kind === "move") this.app.gizmo.move(x, y, true);
    if (held.kind === "touch") this.app.send({ ...held.last, velocity: [0, 0, 0], done: true });
  }

  // The point of snow or of a solid under the pointer; without any, one in the depth of the target.
  hit(x, y) {
    const camera = this.app.camera, ray = camera.ray(x, y);
    const snow = this.snowHit(camera.eye, ray), solid = this.solidHit(camera.eye, ray);
    if (snow !== null && (solid === null || snow <= solid.t)) return { point: V.mad(camera.eye, ray, snow), t: snow, what: "snow" };
    if (solid !== null) return { point: V.mad(camera.eye, ray, solid.t), t: solid.t, what: solid.name };
    const t = camera.distance / Math.max(V.dot(ray, camera.forward), 0.05);
    return { point: V.mad(camera.eye, ray, t), t, what: "" };
  }

  snowHit(eye, ray) {
    const { moment, scene } = this.app;
    if (!moment) return null;
    const { q, n, low, step } = moment, radius = (1.2 * scene.spacing) ** 2;
    const sx = step[0], sy = step[1], sz = step[2], ox = low[0] - eye[0], oy = low[1] - eye[1], oz = low[2] - eye[2];
    let best = Infinity;
    for (let i = 0; i < n; i++) {
      const x = ox + sx * q[4 * i], y = oy + sy * q[4 * i + 1], z = oz + sz * q[4 * i + 2];
      const t = x * ray[0] + y * ray[1] + z * ray[2];
      if (t <= 0 || t >= best) continue;
      if (x * x + y * y + z * z - t * t < radius) best = t;
    }
    return best === Infinity ? null : best;
  }

  solidHit(eye, ray) {
    let best = null;
    this.app.scene.solids.forEach((solid, i) => {
      const model = this.app.stage.modelOf(i);
      if (!model || !solid.visible) return;
      const local = (v) => [0, 1, 2].map((k) => V.dot(R.column(model.turn, k), v));
      const t = meet(solid, local(V.sub(eye, model.place)), local(ray));
      if (t !== null && (!best || t < best.t)) best = { t, name: solid.name };
    });
    return best;
  }

  throw(x, y) {
    const camera = this.app.camera, radius = Math.max(2.5 * this.app.scene.dx, 0.025 * camera.distance);
    const ray = camera.ray(x, y), from = V.mad(V.mad(camera.eye, ray, 0.3 * camera.distance), camera.up, -0.06 * camera.distance);
    const aim = V.unit(V.sub(V.mad(camera.eye, ray, camera.distance), from));
    this.app.send({ do: "throw", origin: from, direction: aim, speed: this.ballSpeed, radius });
  }

  beginMove(x, y) {
    const part = this.app.gizmo.pick(x, y);
    if (part && this.app.gizmo.begin(part, x, y)) return void (this.held.kind = "move");
    const found = this.hit(x, y);
    const known = this.app.scene.solids.some((s) => s.name === found.what);
    this.app.select(known ? found.what : "");
    if (!known || this.app.scene.solids.find((s) => s.name === found.what).shape === "plane") return;
    if (this.app.gizmo.begin({ kind: "slide", axis: 2 }, x, y)) this.held.kind = "move";
  }

  beginTouch(x, y) {
    const found = this.hit(x, y);
    this.held.kind = "touch";
    this.held.depth = V.dot(V.sub(found.point, this.app.camera.eye), this.app.camera.forward);
    this.held.point = found.point;
    this.touch(x, y);
  }

  touch(x, y) {
    const camera = this.app.camera, ray = camera.ray(x, y), now = performance.now();
    const point = V.mad(camera.eye, ray, this.held.depth / Math.max(V.dot(ray, camera.forward), 0.05));
    const seconds = Math.max((now - this.held.time) / 1000, 0.008);
    const velocity = V.scale(V.sub(point, this.held.point), 1 / seconds);
    this.held.point = point, this.held.time = now;
    const radius = Math.max(4 * this.app.scene.dx, 0.045 * camera.distance);
    this.held.last = { do: "touch", tool: this.tool, point, velocity, radius, done: false };
    this.app.send(this.held.last);
  }

  // While a button is held and the pointer rests, the hand rests too.
  tick() {
    const held = this.held;
    if (held && held.kind === "touch" && performance.now() - held.time > 90) {
      held.time = performance.now();
      this.app.send({ ...held.last, point: held.point, velocity: [0, 0, 0] });
    }
  }
}

// Where a ray meets a solid in the solid's own frame; null if it does not.
function meet(solid, eye, ray) {
  const half = solid.half, least = (a, b) => (a > 1e-6 ? a : b > 1e-6 ? b : null);
  if (solid.shape === "plane") return eye[2] > 0 && ray[2] < 0 ? -eye[2] / ray[2] : null;
  if (solid.shape === "sphere") {
    const b = V.dot(eye, ray), c = V.dot(eye, eye) - half[0] ** 2, d = b * b - c;
    return d < 0 ? null : least(-b - Math.sqrt(d), -b + Math.sqrt(d));
  }
  const size = solid.mesh ? boundOf(solid) : half;
  let near = -Infinity, far = Infinity;
  for (let k = 0; k < 3; k++) {
    const inv = 1 / (Math.abs(ray[k]) > 1e-12 ? ray[k] : 1e-12), a = (-size[k] - eye[k]) * inv, b = (size[k] - eye[k]) * inv;
    near = Math.max(near, Math.min(a, b)), far = Math.min(far, Math.max(a, b));
  }
  return near > far ? null : least(near, far);
}

function boundOf(solid) {
  if (!solid.bound) {
    const all = new Float32Array(Uint8Array.from(atob(solid.mesh.vertices), (c) => c.charCodeAt(0)).buffer);
    solid.bound = [0, 0, 0];
    for (let i = 0; i < all.length; i++) solid.bound[i % 3] = Math.max(solid.bound[i % 3], Math.abs(all[i]));
  }
  return solid.bound;
}
