"""Say where a collider is and how it moves at any time."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import Pose, rotation_matrix, rotation_to_normal, rotation_vector
from neve.reproducible import product
from neve.scene.schema.scene import Collider, Keyframe

Array = NDArray[np.float64]


def pose(collider: Collider, t: float) -> Pose:
    """Return where `collider` is at time `t` [s] and how it moves.

    With keyframes: linear in position, constant rate of turn; at a keyframe the motion that follows counts;
    at rest before the first and from the last on. Otherwise constant velocity and spin from t = 0 on.
    """
    if collider.keyframes:
        return _between_keyframes(collider, t)
    velocity, spin = np.array(collider.velocity), np.array(collider.spin)
    return Pose(
        _position(collider) + t * velocity,
        product(rotation_matrix(t * spin), _rotation(collider)),
        velocity,
        spin,
    )


def _between_keyframes(collider: Collider, t: float) -> Pose:
    keys = collider.keyframes
    i = bisect_right([key.t for key in keys], t) - 1
    if i < 0 or i == len(keys) - 1:
        key = keys[max(i, 0)]
        return Pose(_position(collider, key), _rotation(collider, key), np.zeros(3), np.zeros(3))
    a, b = keys[i], keys[i + 1]
    span, share = b.t - a.t, (t - a.t) / (b.t - a.t)
    x0, R0 = _position(collider, a), _rotation(collider, a)
    displacement = _position(collider, b) - x0
    angle = rotation_vector(product(_rotation(collider, b), R0.T))
    return Pose(
        x0 + share * displacement,
        product(rotation_matrix(share * angle), R0),
        displacement / span,
        angle / span,
    )


def _position(collider: Collider, key: Keyframe | None = None) -> Array:
    if key is not None and key.position is not None:
        return np.array(key.position)
    return np.array(collider.place)


def _rotation(collider: Collider, key: Keyframe | None = None) -> Array:
    vector = collider.turned if key is None or key.rotation is None else key.rotation
    R = rotation_matrix(np.radians(vector))
    return R if collider.facing is None else product(R, rotation_to_normal(np.array(collider.facing)))
