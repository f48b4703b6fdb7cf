/** The little geometry of rigid bodies that the car needs: vectors as triples, rotations as quaternions (x, y, z, w). */
export type Vec = [number, number, number];
export type Quaternion = [number, number, number, number];

/** A vector turned by a rotation. */
export function turn([x, y, z, w]: Readonly<Quaternion>, [a, b, c]: readonly [number, number, number]): Vec {
  const tx = 2 * (y * c - z * b);
  const ty = 2 * (z * a - x * c);
  const tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

/** Product of two rotations: first b, then a. */
export function multiply(a: Readonly<Quaternion>, b: Readonly<Quaternion>): Quaternion {
  return [
    a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
    a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
    a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
    a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
  ];
}

/** Rotation about the upward axis [rad]. */
export function yaw(angle: number): Quaternion {
  return [0, Math.sin(angle / 2), 0, Math.cos(angle / 2)];
}

export function add(a: Readonly<Vec>, b: Readonly<Vec>): Vec {
  return [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
}

export function scale(a: Readonly<Vec>, s: number): Vec {
  return [a[0] * s, a[1] * s, a[2] * s];
}

export function dot(a: Readonly<Vec>, b: Readonly<Vec>): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross(a: Readonly<Vec>, b: Readonly<Vec>): Vec {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** The vector at length 1; a vector of length 0 gives east. */
export function unit(a: Readonly<Vec>): Vec {
  const length = Math.hypot(...a);
  return length > 1e-12 ? scale(a, 1 / length) : [1, 0, 0];
}

/** The part of a vector in the plane with the unit normal n. */
export function inPlane(a: Readonly<Vec>, n: Readonly<Vec>): Vec {
  return add(a, scale(n, -dot(a, n)));
}

/** Blend of two vectors. */
export function between(a: Readonly<Vec>, b: Readonly<Vec>, t: number): Vec {
  return [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t];
}

/** Blend of two rotations that are close together: straight, then back to length 1. */
export function betweenTurns(a: Readonly<Quaternion>, b: Readonly<Quaternion>, t: number): Quaternion {
  const sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
  const q = a.map((value, i) => value + (sign * b[i]! - value) * t) as Quaternion;
  const length = Math.hypot(...q);
  return q.map((value) => value / length) as Quaternion;
}
