"""Say where a collider is and how it moves at any time."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.scene.scene import Collider, Keyframe, Plane, Sphere

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """Hold the place and the motion of a body's own frame in the world at one time.

    The frame's origin is the centre of the body (of a plane: its point); a plane's own z is its normal.

    Attributes:
        position: origin of the frame [m], (3,)
        rotation: matrix from the body's axes to the world's [1], (3, 3)
        velocity: of the origin [m/s], (3,)
        omega: angular velocity in world axes [rad/s], (3,)
    """

    position: Array
    rotation: Array
    velocity: Array
    omega: Array


def pose(collider: Collider, t: float) -> Pose:
    """Return where `collider` is at time `t` [s] and how it moves.

    With keyframes: linear in position, constant rate of turn; at a keyframe the motion that follows counts;
    at rest before the first and from the last on. Otherwise constant velocity and spin from t = 0 on.
    """
    if collider.keyframes:
        return _between_keyframes(collider, t)
    velocity, spin = np.array(collider.velocity), np.array(collider.spin)
    return Pose(_position(collider) + t * velocity, turn(t * spin) @ _rotation(collider), velocity, spin)


def turn(vector: Array) -> Array:
    """Return the matrix (3, 3) that rotates by |vector| [rad] about `vector` (Rodrigues' formula)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * k + 2.0 * np.sin(0.5 * angle) ** 2 * (k @ k))


def cross(a: Array, b: Array) -> Array:
    """Return a x b of single vectors (3,): np.cross takes thirty times as long for so few numbers."""
    (a0, a1, a2), (b0, b1, b2) = a.tolist(), b.tolist()
    return np.array((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0))


def rotation_vector(matrix: Array) -> Array:
    """Return the rotation vector [rad] (3,) of a rotation `matrix` (3, 3), at most half a turn long."""
    q = quaternion_of(matrix)
    sine = float(np.linalg.norm(q[1:]))
    if sine == 0.0:
        return np.zeros(3)
    return np.asarray(q[1:] / sine * 2.0 * np.arctan2(sine, q[0]))


def quaternion_of(matrix: Array) -> Array:
    """Return the unit quaternion (w, x, y, z), w >= 0, of a rotation `matrix` (3, 3).

    Reads it from its largest component (Shepperd 1978), which stays accurate at half a turn.
    """
    m = matrix
    trace = float(np.trace(m))
    columns = np.array(
        [
            [1 + trace, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], 1 - trace + 2 * m[0, 0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 1 - trace + 2 * m[1, 1], m[1, 2] + m[2, 1]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1 - trace + 2 * m[2, 2]],
        ]
    )
    q = columns[int(np.argmax(np.diag(columns)))]
    return np.asarray(q / np.linalg.norm(q) * (1.0 if q[0] >= 0 else -1.0))


def _between_keyframes(collider: Collider, t: float) -> Pose:
    keys = collider.keyframes
    i = bisect_right([key.t for key in keys], t) - 1
    if i < 0 or i == len(keys) - 1:
        rest = keys[max(i, 0)]
        return Pose(_position(collider, rest), _rotation(collider, rest), np.zeros(3), np.zeros(3))
    a, b = keys[i], keys[i + 1]
    span, share = b.t - a.t, (t - a.t) / (b.t - a.t)
    x0, R0 = _position(collider, a), _rotation(collider, a)
    way = _position(collider, b) - x0
    angle = rotation_vector(_rotation(collider, b) @ R0.T)
    return Pose(x0 + share * way, turn(share * angle) @ R0, way / span, angle / span)


def _position(collider: Collider, key: Keyframe | None = None) -> Array:
    if key is not None and key.position is not None:
        return np.array(key.position)
    return np.array(collider.point if isinstance(collider, Plane) else collider.center)


def _rotation(collider: Collider, key: Keyframe | None = None) -> Array:
    own = (0.0, 0.0, 0.0) if isinstance(collider, (Plane, Sphere)) else collider.rotation
    vector = own if key is None or key.rotation is None else key.rotation
    R = turn(np.radians(vector))
    return R @ _facing(np.array(collider.normal)) if isinstance(collider, Plane) else R


def _facing(normal: Array) -> Array:
    """Return the shortest rotation (3, 3) that takes z to the direction of `normal`."""
    n = normal / np.linalg.norm(normal)
    axis = np.array([-n[1], n[0], 0.0])
    sine = float(np.linalg.norm(axis))
    if sine == 0.0:
        return np.diag([1.0, n[2], n[2]])
    return turn(axis / sine * np.arctan2(sine, n[2]))
