// The particles of a state on the graphics card.

/** @import { StateHead } from "../protocol.js" */
/** @import { Vec3 } from "./math.js" */
/** @typedef {StateHead & { q: Uint16Array }} State a state with its particles: x, y, z and a value each */

import { PARTICLE_BYTES } from "../protocol.js";
import { V } from "./math.js";

export class SnowCloud {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.buffer = gl.createBuffer();
    /** @type {Map<number, WebGLVertexArrayObject>} */
    this.arrays = new Map();
    this.count = 0;
    /** @type {Vec3} */
    this.low = [0, 0, 0];
    /** @type {Vec3} */
    this.step = [1, 1, 1];
    this.ball = [0, 0, 0, 1];
  }

  /**
   * @param {State} state
   * @param {Uint16Array} [rows] those of its particles that are drawn here; all if it is left out
   */
  load(state, rows = state.q) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, rows, gl.STREAM_DRAW);
    this.count = rows.length / 4;
    this.low = state.low;
    this.step = state.step;
    this.ball = ballOf(state); // of all, so that water and snow are seen from the same place
  }

  /** @returns {Vec3} middle of the snow [m] */
  middle() {
    return [this.ball[0], this.ball[1], this.ball[2]];
  }

  /**
   * Return a vertex array that takes every k-th particle.
   * @param {number} k
   */
  array(k) {
    const known = this.arrays.get(k);
    if (known) return known;
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, false, PARTICLE_BYTES * k, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 1, gl.UNSIGNED_SHORT, false, PARTICLE_BYTES * k, 6);
    gl.bindVertexArray(null);
    this.arrays.set(k, array);
    return array;
  }
}

/**
 * Return centre and radius [m] of a ball that holds all but a few lost particles: shadows are drawn inside it.
 * @param {State} state
 */
function ballOf({ n, q, low, step }) {
  if (!n) return [...low, 1];
  const stride = Math.max(1, Math.floor(n / 3000));
  /** @type {Vec3} */
  const middle = [0, 0, 0];
  /** @type {Vec3} */
  const half = [0, 0, 0];
  for (let axis = 0; axis < 3; axis++) {
    const values = [];
    for (let i = 0; i < n; i += stride) values.push(q[4 * i + axis]);
    values.sort((a, b) => a - b);
    const cut = Math.floor(values.length * 0.003);
    const first = low[axis] + step[axis] * values[cut];
    const last = low[axis] + step[axis] * values[values.length - 1 - cut];
    middle[axis] = 0.5 * (first + last);
    half[axis] = 0.5 * (last - first);
  }
  return [...middle, Math.max(1.1 * V.length(half), 1e-3)];
}
