"use strict";
// Vectors of three numbers and matrices of sixteen (columns first, as WebGL has them). z is up.

const V = {
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  scale: (a, s) => [a[0] * s, a[1] * s, a[2] * s],
  mad: (a, b, s) => [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  length: (a) => Math.hypot(a[0], a[1], a[2]),
  unit(a) {
    const n = Math.hypot(a[0], a[1], a[2]) || 1;
    return [a[0] / n, a[1] / n, a[2] / n];
  },
  mix: (a, b, t) => [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t],
};

const M = {
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
  perspective(fov, aspect, near, far) {
    const f = 1 / Math.tan((fov * Math.PI) / 360), d = near - far;
    // prettier-ignore
    return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, (2 * far * near) / d, 0]);
  },
  // View along `forward` with right and upward directions of the picture.
  view(eye, right, up, forward) {
    // prettier-ignore
    return new Float32Array([
      right[0], up[0], -forward[0], 0, right[1], up[1], -forward[1], 0, right[2], up[2], -forward[2], 0,
      -V.dot(right, eye), -V.dot(up, eye), V.dot(forward, eye), 1,
    ]);
  },
  // A body's frame: nine numbers row by row, and where it is.
  frame(r, p) {
    return new Float32Array([r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0, p[0], p[1], p[2], 1]);
  },
};

// Rotations as nine numbers, row by row.
const R = {
  times(a, b) {
    const out = [];
    for (let i = 0; i < 3; i++)
      for (let j = 0; j < 3; j++) out.push(a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j]);
    return out;
  },
  about(axis, angle) {
    const [x, y, z] = V.unit(axis), c = Math.cos(angle), s = Math.sin(angle), t = 1 - c;
    return [
      t * x * x + c, t * x * y - s * z, t * x * z + s * y,
      t * x * y + s * z, t * y * y + c, t * y * z - s * x,
      t * x * z - s * y, t * y * z + s * x, t * z * z + c,
    ];
  },
  // Rotation vector in degrees, at most half a turn.
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
  column: (m, k) => [m[k], m[3 + k], m[6 + k]],
};
