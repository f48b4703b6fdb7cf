// The camera: it turns about a target, moves with it, and flies. z is up.

/** @import { PageCamera } from "../commands.js" */
/** @import { Camera } from "../protocol.js" */
/** @import { Vec3 } from "./math.js" */

import { M, V } from "./math.js";

/**
 * Ways to look at all of the snow, from the side on which the scene's own camera stands: turned by an angle about
 * the upward axis, so high above the ground [rad], and at so many times the distance that shows the whole.
 * @type {Record<string, { turn: number, rise: number, distance: number }>}
 */
export const VIEWS = {
  front: { turn: 0, rise: 0.1, distance: 1 },
  side: { turn: Math.PI / 2, rise: 0.1, distance: 1 },
  back: { turn: Math.PI, rise: 0.1, distance: 1 },
  above: { turn: 0, rise: 1.5, distance: 1 },
  close: { turn: 0.3, rise: 0.35, distance: 0.4 },
};

/** @typedef {Pick<Camera, "position" | "target" | "fov">} Home */

export class OrbitCamera {
  constructor() {
    /** @type {Home} */
    this.home = { position: [4, -6, 2], target: [0, 0, 0.5], fov: 35 };
    /** @type {Vec3} */
    this.target = [0, 0, 0];
    this.distance = 1;
    this.azimuth = 0;
    this.elevation = 0;
    this.fov = 35;
    /** @type {Set<string>} keys that are held */
    this.keys = new Set();
    this.set(this.home);
    this.covered = 0;
    this.width = this.height = 1;
    /** @type {Vec3} */
    this.eye = [0, 0, 0];
    /** @type {Vec3} */
    this.forward = [0, 1, 0];
    /** @type {Vec3} */
    this.right = [1, 0, 0];
    /** @type {Vec3} */
    this.up = [0, 0, 1];
    this.tan = [1, 1];
    this.focal = 1;
    this.lens = [1, 0];
    this.matrix = new Float32Array(16);
    this.update(1, 1);
  }

  /**
   * Take the camera of a scene.
   * @param {Home} home
   */
  set({ position, target, fov }) {
    const back = V.sub(position, target);
    this.target = [...target];
    this.distance = Math.max(V.length(back), 1e-3);
    this.azimuth = Math.atan2(back[1], back[0]);
    this.elevation = Math.asin(Math.max(-1, Math.min(1, back[2] / this.distance)));
    this.fov = fov;
    this.home = { position, target, fov };
  }

  /**
   * Take one of VIEWS of a ball.
   * @param {string} name
   * @param {Vec3} middle
   * @param {number} radius
   */
  see(name, middle, radius) {
    const back = V.sub(this.home.position, this.home.target);
    const { turn, rise, distance } = VIEWS[name];
    this.fov = this.home.fov;
    this.target = middle;
    this.azimuth = Math.atan2(back[1], back[0]) + turn;
    this.elevation = rise;
    this.distance = (distance * radius) / Math.sin((this.fov * Math.PI) / 360);
  }

  /**
   * @param {number} right [rad]
   * @param {number} down [rad]
   */
  turn(right, down) {
    this.azimuth -= right;
    this.elevation = Math.max(-1.5, Math.min(1.55, this.elevation + down));
  }

  /** @param {number} factor */
  zoom(factor) {
    this.distance = Math.max(1e-3, Math.min(1e5, this.distance * factor));
  }

  /**
   * Move by shares of half the picture's height.
   * @param {number} right
   * @param {number} down
   */
  pan(right, down) {
    const s = this.distance * Math.tan((this.fov * Math.PI) / 360);
    this.target = V.mad(V.mad(this.target, this.right, -right * s), this.up, down * s);
  }

  /**
   * Fly for some seconds as the keys say.
   * @param {number} seconds
   * @returns {boolean} whether it moved
   */
  fly(seconds) {
    /** @param {string[]} names */
    const held = (...names) => (names.some((name) => this.keys.has(name)) ? 1 : 0);
    const ahead = held("w", "arrowup") - held("s", "arrowdown");
    const side = held("d", "arrowright") - held("a", "arrowleft");
    const rise = held("e", "pageup") - held("q", "pagedown");
    if (!ahead && !side && !rise) return false;
    const flat = V.unit([this.forward[0], this.forward[1], 0]);
    const step = 0.9 * this.distance * seconds * (this.keys.has("shift") ? 3 : 1);
    let move = V.scale(flat, ahead * step);
    move = V.mad(move, this.right, side * step);
    move = V.mad(move, [0, 0, 1], rise * step);
    this.target = V.add(this.target, move);
    return true;
  }

  /**
   * Work out the picture's axes and matrices.
   * @param {number} width of the canvas [px]
   * @param {number} height
   * @param {number} covered share of the width on the right under the panel; the rest is what has the middle
   */
  update(width, height, covered = 0) {
    this.covered = covered;
    const c = Math.cos(this.elevation);
    /** @type {Vec3} */
    const back = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
    this.eye = V.mad(this.target, back, this.distance);
    this.forward = V.scale(back, -1);
    this.right = V.unit(V.cross(this.forward, [0, 0, 1]));
    this.up = V.cross(this.right, this.forward);
    const half = Math.tan((this.fov * Math.PI) / 360);
    this.focal = (0.5 * height) / half;
    this.tan = [(half * width) / height, half];
    this.width = width;
    this.height = height;
    const lens = M.perspective(this.fov, width / height, 0.01 * this.distance, 2000 * this.distance);
    this.lens = [-lens[10], lens[14]]; // depth in the picture = (x d + y) / d
    lens[8] = covered; // x' = x / depth - covered
    this.matrix = M.multiply(lens, M.view(this.eye, this.right, this.up, this.forward));
  }

  /**
   * Return the unit vector through a point of the picture.
   * @param {number} x share of its width
   * @param {number} y share of its height
   */
  ray(x, y) {
    const a = (2 * x - 1 + this.covered) * this.tan[0];
    const b = (1 - 2 * y) * this.tan[1];
    return V.unit(V.add(this.forward, V.add(V.scale(this.right, a), V.scale(this.up, b))));
  }

  /**
   * Return where a point of the world is in the picture, in shares of its size, and how far ahead [m].
   * @param {Vec3} p
   * @returns {Vec3}
   */
  project(p) {
    const d = V.sub(p, this.eye);
    const depth = V.dot(d, this.forward);
    const x = V.dot(d, this.right) / depth / this.tan[0] - this.covered;
    const y = V.dot(d, this.up) / depth / this.tan[1];
    return [0.5 + 0.5 * x, 0.5 - 0.5 * y, depth];
  }

  /**
   * Return the camera as a command holds it; the size is even, as films need it.
   * @param {number} asWide as the picture is to be [px]; 0: as the page
   * @param {number} asHigh
   * @returns {PageCamera}
   */
  toCommand(asWide = 0, asHigh = 0) {
    const free = this.width * (1 - this.covered);
    const scale = Math.min(1, 1920 / free);
    /** @param {number} pixels */
    const even = (pixels) => Math.max(16, 2 * Math.round((pixels * scale) / 2));
    const size = asWide
      ? { width: asWide, height: asHigh }
      : { width: even(free), height: even(this.height) };
    return { position: this.eye, target: this.target, up: [0, 0, 1], fov: this.fov, ...size };
  }
}
