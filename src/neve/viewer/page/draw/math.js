// Vectors of three numbers and matrices of sixteen (columns first, as WebGL has them). z is up.

/** @typedef {[number, number, number]} Vec3 */
/** @typedef {[number, number, number, number, number, number, number, number, number]} Rotation row by row */

export const V = {
  /** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  /** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  /** @param {Vec3} a @param {number} s @returns {Vec3} */
  scale: (a, s) => [a[0] * s, a[1] * s, a[2] * s],
  /** @param {Vec3} a @param {Vec3} b @param {number} s @returns {Vec3} a + s b */
  mad: (a, b, s) => [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s],
  /** @param {Vec3} a @param {Vec3} b */
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  /** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  /** @param {Vec3} a */
  length: (a) => Math.hypot(a[0], a[1], a[2]),
  /** @param {Vec3} a @returns {Vec3} */
  unit(a) {
    const n = Math.hypot(a[0], a[1], a[2]) || 1;
    return [a[0] / n, a[1] / n, a[2] / n];
  },
  /** @param {Vec3} a @param {Vec3} b @param {number} t @returns {Vec3} */
  mix: (a, b, t) => [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t],
};

export const M = {
  /** @param {Float32Array} a @param {Float32Array} b */
  multiply(a, b) {
    const out = new Float32Array(16);
    for (let c = 0; c < 4; c++)
      for (let r = 0; r < 4; r++) {
        let sum = 0;
        for (let k = 0; k < 4; k++) sum += a[4 * k + r] * b[4 * c + k];
        out[4 * c + r] = sum;
      }
    return out;
  },
  /**
   * @param {number} fov vertical angle [degrees]
   * @param {number} aspect width over height
   * @param {number} near [m]
   * @param {number} far [m]
   */
  perspective(fov, aspect, near, far) {
    const f = 1 / Math.tan((fov * Math.PI) / 360);
    const d = near - far;
    // prettier-ignore
    return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, (2 * far * near) / d, 0]);
  },
  /**
   * View along `forward` with right and upward directions of the picture.
   * @param {Vec3} eye
   * @param {Vec3} right
   * @param {Vec3} up
   * @param {Vec3} forward
   */
  view(eye, right, up, forward) {
    // prettier-ignore
    return new Float32Array([
      right[0], up[0], -forward[0], 0, right[1], up[1], -forward[1], 0, right[2], up[2], -forward[2], 0,
      -V.dot(right, eye), -V.dot(up, eye), V.dot(forward, eye), 1,
    ]);
  },
  /**
   * The matrix of a body with rotation r at p.
   * @param {Rotation} r
   * @param {Vec3} p
   */
  frame(r, p) {
    return new Float32Array([
      r[0],
      r[3],
      r[6],
      0,
      r[1],
      r[4],
      r[7],
      0,
      r[2],
      r[5],
      r[8],
      0,
      p[0],
      p[1],
      p[2],
      1,
    ]);
  },
};

export const R = {
  /** @param {Rotation} a @param {Rotation} b @returns {Rotation} a b */
  times(a, b) {
    /** @param {number} i @param {number} j */
    const entry = (i, j) => a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    // prettier-ignore
    return [
      entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 0), entry(1, 1), entry(1, 2), entry(2, 0), entry(2, 1), entry(2, 2),
    ];
  },
  /** @param {Vec3} axis @param {number} angle [rad] @returns {Rotation} */
  about(axis, angle) {
    const [x, y, z] = V.unit(axis);
    const c = Math.cos(angle);
    const s = Math.sin(angle);
    const t = 1 - c;
    // prettier-ignore
    return [
      t * x * x + c, t * x * y - s * z, t * x * z + s * y,
      t * x * y + s * z, t * y * y + c, t * y * z - s * x,
      t * x * z - s * y, t * y * z + s * x, t * z * z + c,
    ];
  },
  /** @param {Rotation} m @returns {Vec3} rotation vector, at most half a turn [degrees] */
  vector(m) {
    const trace = m[0] + m[4] + m[8];
    const rows = [
      [1 + trace, m[7] - m[5], m[2] - m[6], m[3] - m[1]],
      [m[7] - m[5], 1 - trace + 2 * m[0], m[1] + m[3], m[2] + m[6]],
      [m[2] - m[6], m[1] + m[3], 1 - trace + 2 * m[4], m[5] + m[7]],
      [m[3] - m[1], m[2] + m[6], m[5] + m[7], 1 - trace + 2 * m[8]],
    ];
    let best = 0;
    for (let i = 1; i < 4; i++) if (rows[i][i] > rows[best][best]) best = i;
    let q = rows[best];
    const n = Math.hypot(...q) * (q[0] < 0 ? -1 : 1);
    q = q.map((a) => a / n);
    const sine = Math.hypot(q[1], q[2], q[3]);
    if (sine < 1e-12) return [0, 0, 0];
    const angle = (2 * Math.atan2(sine, q[0]) * 180) / Math.PI;
    return [(q[1] / sine) * angle, (q[2] / sine) * angle, (q[3] / sine) * angle];
  },
  /** @param {Rotation} m @param {number} k @returns {Vec3} */
  column: (m, k) => [m[k], m[3 + k], m[6 + k]],
};
