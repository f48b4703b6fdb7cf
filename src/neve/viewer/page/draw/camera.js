"use strict";
// The camera: it turns about a target, moves with it, and flies. z is up.

// Ways to look at all of the snow, from the side on which the scene's own camera stands: turned by an angle about
// the upward axis, so high above the ground [rad], and at so many times the distance that shows the whole.
const VIEWS = { front: [0, 0.1, 1], side: [Math.PI / 2, 0.1, 1], back: [Math.PI, 0.1, 1], above: [0, 1.5, 1], close: [0.3, 0.35, 0.4] };

class Camera {
  constructor() {
    this.set({ position: [4, -6, 2], target: [0, 0, 0.5], up: [0, 0, 1], fov: 35 });
    this.keys = new Set();
  }

  // Take the camera of a scene.
  set({ position, target, fov }) {
    const back = V.sub(position, target);
    this.target = [...target];
    this.distance = Math.max(V.length(back), 1e-3);
    this.azimuth = Math.atan2(back[1], back[0]);
    this.elevation = Math.asin(Math.max(-1, Math.min(1, back[2] / this.distance)));
    this.fov = fov;
    this.home = { position, target, fov };
  }

  // Take one of VIEWS of a ball: its middle and radius.
  see(name, ball) {
    const back = V.sub(this.home.position, this.home.target), [turn, rise, distance] = VIEWS[name];
    this.fov = this.home.fov;
    this.target = ball.slice(0, 3);
    this.azimuth = Math.atan2(back[1], back[0]) + turn;
    this.elevation = rise;
    this.distance = (distance * ball[3]) / Math.sin((this.fov * Math.PI) / 360);
  }

  turn(right, down) {
    this.azimuth -= right;
    this.elevation = Math.max(-1.5, Math.min(1.55, this.elevation + down));
  }

  zoom(factor) {
    this.distance = Math.max(1e-3, Math.min(1e5, this.distance * factor));
  }

  pan(right, down) {
    const s = this.distance * Math.tan((this.fov * Math.PI) / 360);
    this.target = V.mad(V.mad(this.target, this.right, -right * s), this.up, down * s);
  }

  // Fly for some seconds as the keys say.
  fly(seconds) {
    const k = this.keys, on = (...names) => (names.some((n) => k.has(n)) ? 1 : 0);
    const ahead = on("w", "arrowup") - on("s", "arrowdown"), side = on("d", "arrowright") - on("a", "arrowleft");
    const rise = on("e", "pageup") - on("q", "pagedown");
    if (!ahead && !side && !rise) return false;
    const flat = V.unit([this.forward[0], this.forward[1], 0]), step = 0.9 * this.distance * seconds * (k.has("shift") ? 3 : 1);
    let move = V.scale(flat, ahead * step);
    move = V.mad(move, this.right, side * step);
    move = V.mad(move, [0, 0, 1], rise * step);
    this.target = V.add(this.target, move);
    return true;
  }

  // Work out the picture's axes and matrices for a canvas of so many pixels; `covered`: share of its width on
  // the right under the panel, from whose free rest the middle is taken.
  update(width, height, covered = 0) {
    this.covered = covered;
    const c = Math.cos(this.elevation);
    const back = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
    this.eye = V.mad(this.target, back, this.distance);
    this.forward = V.scale(back, -1);
    this.right = V.unit(V.cross(this.forward, [0, 0, 1]));
    this.up = V.cross(this.right, this.forward);
    this.reach = this.distance;
    const half = Math.tan((this.fov * Math.PI) / 360);
    this.focal = (0.5 * height) / half;
    this.tan = [(half * width) / height, half];
    this.width = width, this.height = height;
    const near = 0.01 * this.distance, far = 2000 * this.distance;
    const lens = M.perspective(this.fov, width / height, near, far);
    lens[8] = covered;  // x' = x / depth - covered
    this.matrix = M.multiply(lens, M.view(this.eye, this.right, this.up, this.forward));
  }

  // Unit vector through a point of the picture, in shares of its size.
  ray(x, y) {
    const a = (2 * x - 1 + this.covered) * this.tan[0], b = (1 - 2 * y) * this.tan[1];
    return V.unit(V.add(this.forward, V.add(V.scale(this.right, a), V.scale(this.up, b))));
  }

  // Where a point of the world is in the picture, in shares of its size, and how far ahead [m].
  project(p) {
    const d = V.sub(p, this.eye), depth = V.dot(d, this.forward);
    return [0.5 + (0.5 * V.dot(d, this.right)) / depth / this.tan[0] - 0.5 * this.covered, 0.5 - (0.5 * V.dot(d, this.up)) / depth / this.tan[1], depth];
  }

  // As a command tells it to the server.
  told() {
    const width = this.width * (1 - this.covered), scale = Math.min(1, 1920 / width);
    const even = (a) => Math.max(16, 2 * Math.round((a * scale) / 2));
    return {
      position: this.eye, target: this.target, up: [0, 0, 1], fov: this.fov, width: even(width), height: even(this.height),
    };
  }
}
