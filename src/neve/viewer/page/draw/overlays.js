// Triangles of figures that are drawn over the picture: boxes, lines and rings.

/** @import { Vec3 } from "./math.js" */

import { V } from "./math.js";

/**
 * The twelve triangles of a box.
 * @param {Vec3} middle
 * @param {number[]} half of its edges
 */
export function boxTriangles(middle, half) {
  /** @type {Vec3[]} */
  const points = [];
  for (let axis = 0; axis < 3; axis++)
    for (const side of [-1, 1])
      for (const [a, b] of [
        [-1, -1],
        [1, -1],
        [1, 1],
        [-1, -1],
        [1, 1],
        [-1, 1],
      ]) {
        /** @type {Vec3} */
        const at = [...middle];
        at[axis] += side * half[axis];
        at[(axis + 1) % 3] += a * half[(axis + 1) % 3];
        at[(axis + 2) % 3] += b * half[(axis + 2) % 3];
        points.push(at);
      }
  return points;
}

/**
 * A line as a band that faces the eye.
 * @param {Vec3} from
 * @param {Vec3} to
 * @param {Vec3} eye
 * @param {number} pixel size of a pixel one metre ahead [m]
 */
export function lineTriangles(from, to, eye, pixel) {
  const way = V.sub(to, from);
  /** @param {Vec3} at @returns {Vec3} */
  const side = (at) => {
    const back = V.sub(eye, at);
    return V.scale(V.unit(V.cross(way, back)), 1.5 * pixel * V.length(back));
  };
  const [a, b] = [side(from), side(to)];
  const [p, q, r, s] = [V.add(from, a), V.sub(from, a), V.add(to, b), V.sub(to, b)];
  return [p, q, r, r, q, s];
}

/**
 * A ring around a point that faces the eye.
 * @param {Vec3} middle
 * @param {number} radius
 * @param {Vec3} right
 * @param {Vec3} up
 */
export function ringTriangles(middle, radius, right, up) {
  /** @type {Vec3[]} */
  const points = [];
  /** @type {Vec3[]} */
  let last = [];
  for (let i = 0; i <= 48; i++) {
    const t = (i / 48) * 2 * Math.PI;
    const out = V.add(V.scale(right, Math.cos(t)), V.scale(up, Math.sin(t)));
    const pair = [V.mad(middle, out, radius), V.mad(middle, out, 0.97 * radius)];
    if (last.length) points.push(last[0], last[1], pair[0], pair[0], last[1], pair[1]);
    last = pair;
  }
  return points;
}
