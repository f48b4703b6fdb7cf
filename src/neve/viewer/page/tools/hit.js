// What a ray from the eye meets: snow or a solid.

/** @import { Solid } from "../protocol.js" */
/** @import { Vec3 } from "../draw/math.js" */
/** @import { State } from "../draw/snow_cloud.js" */
/** @import { Clip, Stage } from "../draw/stage.js" */

import { R, V } from "../draw/math.js";
import { bytesOf } from "../draw/meshes.js";

/**
 * Return how far along the ray the snow is [m], and which particle.
 * @param {State} state
 * @param {number} spacing of particles [m]
 * @param {Vec3} eye
 * @param {Vec3} ray
 * @param {Clip | null} clip
 */
export function snowHit({ q, n, low, step }, spacing, eye, ray, clip) {
  const square = (1.2 * spacing) ** 2;
  const [sx, sy, sz] = step;
  const [ox, oy, oz] = V.sub(low, eye);
  let best = Infinity;
  let particle = -1;
  for (let i = 0; i < n; i++) {
    const x = ox + sx * q[4 * i];
    const y = oy + sy * q[4 * i + 1];
    const z = oz + sz * q[4 * i + 2];
    const t = x * ray[0] + y * ray[1] + z * ray[2];
    if (t <= 0 || t >= best || x * x + y * y + z * z - t * t >= square) continue;
    if (clip && V.dot(clip.normal, V.mad(eye, ray, t)) > clip.at) continue;
    best = t;
    particle = i;
  }
  return { t: best, particle };
}

/**
 * Return how far along the ray the first solid is [m] of which a plane leaves something there, and its name.
 * @param {Stage} stage
 * @param {Vec3} eye
 * @param {Vec3} ray
 */
export function solidHit(stage, eye, ray) {
  let best = { t: Infinity, name: "" };
  (stage.scene?.solids ?? []).forEach((solid, i) => {
    const pose = stage.poseOf(i);
    if (!pose || !solid.visible) return;
    /** @param {Vec3} v @returns {Vec3} */
    const local = (v) => [
      V.dot(R.column(pose.turn, 0), v),
      V.dot(R.column(pose.turn, 1), v),
      V.dot(R.column(pose.turn, 2), v),
    ];
    const inside = meet(solid, local(V.sub(eye, pose.place)), local(ray));
    const [near, far] = stage.clip && !solid.ground ? left(inside, eye, ray, stage.clip) : inside;
    const t = near > far ? Infinity : firstAhead(near, far);
    if (t < best.t) best = { t, name: solid.name };
  });
  return best;
}

/**
 * Return from where to where [m] a ray, in the solid's own frame, is in a solid; of meshes, in the box around them.
 * The second is less than the first where it passes by.
 * @param {Solid} solid
 * @param {Vec3} eye
 * @param {Vec3} ray
 * @returns {[number, number]}
 */
function meet(solid, eye, ray) {
  if (solid.shape === "plane") {
    const t = eye[2] > 0 && ray[2] < 0 ? -eye[2] / ray[2] : Infinity;
    return [t, t];
  }
  if (solid.shape === "sphere") {
    const b = V.dot(eye, ray);
    const d = b * b - V.dot(eye, eye) + solid.half[0] ** 2;
    return d < 0 ? [Infinity, -Infinity] : [-b - Math.sqrt(d), -b + Math.sqrt(d)];
  }
  const size = solid.mesh ? boundOf(solid.mesh.vertices) : solid.half;
  let near = -Infinity;
  let far = Infinity;
  for (let k = 0; k < 3; k++) {
    const inverse = 1 / (Math.abs(ray[k]) > 1e-12 ? ray[k] : 1e-12);
    const a = (-size[k] - eye[k]) * inverse;
    const b = (size[k] - eye[k]) * inverse;
    near = Math.max(near, Math.min(a, b));
    far = Math.min(far, Math.max(a, b));
  }
  return [near, far];
}

/**
 * Return what a plane leaves of a part of a ray.
 * @param {[number, number]} part from where to where [m]
 * @param {Vec3} eye
 * @param {Vec3} ray
 * @param {Clip} clip
 * @returns {[number, number]}
 */
function left([near, far], eye, ray, { normal, at }) {
  const [beyond, rate] = [V.dot(normal, eye) - at, V.dot(normal, ray)];
  if (Math.abs(rate) < 1e-12) return beyond > 0 ? [Infinity, -Infinity] : [near, far];
  const t = -beyond / rate;
  return rate > 0 ? [near, Math.min(far, t)] : [Math.max(near, t), far];
}

/**
 * @param {number} a
 * @param {number} b
 */
function firstAhead(a, b) {
  if (a > 1e-6) return a;
  return b > 1e-6 ? b : Infinity;
}

/** @type {Map<string, Vec3>} */
const bounds = new Map();

/**
 * Return half of the size of a mesh [m], whose frame is in its middle.
 * @param {string} vertices in base64
 */
function boundOf(vertices) {
  let bound = bounds.get(vertices);
  if (!bound) {
    bound = [0, 0, 0];
    const all = new Float32Array(bytesOf(vertices));
    for (let i = 0; i < all.length; i++) bound[i % 3] = Math.max(bound[i % 3], Math.abs(all[i]));
    bounds.set(vertices, bound);
  }
  return bound;
}
