"""Rotations, and where a solid's frame is and how it moves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """Hold the position and the motion of a solid's own frame in the world at one time.

    The frame's origin is the centre of the solid (of a plane: its point); a plane's own z is its normal.

    Attributes:
        position: origin of the frame [m], (3,)
        rotation: matrix from the solid's axes to the world's [1], (3, 3)
        velocity: of the origin [m/s], (3,)
        omega: angular velocity in world axes [rad/s], (3,)
    """

    position: Array
    rotation: Array
    velocity: Array
    omega: Array

    @classmethod
    def at_rest(cls, position: NDArray[Any], rotation: NDArray[Any]) -> Pose:
        """Return the pose of a solid that is drawn: `position` [m] and `rotation` [1], of any float type."""
        still = np.zeros(3)
        return cls(np.asarray(position, np.float64), np.asarray(rotation, np.float64), still, still)


def rotation_matrix(vector: Array) -> Array:
    """Return the matrix (3, 3) that rotates by |vector| [rad] about `vector` (Rodrigues' formula)."""
    angle = math.hypot(*vector)
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (float(a) / angle for a in vector)
    sine, rest = math.sin(angle), 2.0 * math.sin(0.5 * angle) ** 2
    # 1 + sine k + rest k k element by element: NumPy takes ten times as long for so few numbers
    return np.array(
        (
            (1.0 + rest * (-z * z - y * y), rest * (y * x) - sine * z, sine * y + rest * (z * x)),
            (sine * z + rest * (x * y), 1.0 + rest * (-z * z - x * x), rest * (z * y) - sine * x),
            (rest * (x * z) - sine * y, sine * x + rest * (y * z), 1.0 + rest * (-y * y - x * x)),
        )
    )


def cross(a: Array, b: Array) -> Array:
    """Return a x b of single vectors (3,): np.cross takes thirty times as long for so few numbers."""
    (a0, a1, a2), (b0, b1, b2) = a.tolist(), b.tolist()
    return np.array((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0))


def rotation_vector(matrix: Array) -> Array:
    """Return the rotation vector [rad] (3,) of a rotation `matrix` (3, 3), at most half a turn long."""
    q = quaternion_of(matrix)
    sine = math.hypot(*q[1:])
    if sine == 0.0:
        return np.zeros(3)
    return np.asarray(q[1:] / sine * 2.0 * math.atan2(sine, q[0]))


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
    return np.asarray(q / math.hypot(*q) * (1.0 if q[0] >= 0 else -1.0))


def rotation_to_normal(normal: Array) -> Array:
    """Return the shortest rotation (3, 3) that takes z to the direction of `normal`."""
    n = normal / math.hypot(*normal)
    axis = np.array([-n[1], n[0], 0.0])
    sine = math.hypot(*axis)
    if sine == 0.0:
        return np.diag([1.0, n[2], n[2]])
    return rotation_matrix(axis / sine * math.atan2(sine, n[2]))
