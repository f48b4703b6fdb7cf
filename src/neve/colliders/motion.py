"""Say where a collider is and how it moves at any time."""

from __future__ import annotations

from bisect import bisect_right
from typing import NamedTuple

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
        return _path_of(collider).at(t)
    velocity, spin = np.array(collider.velocity), np.array(collider.spin)
    return Pose(
        _position(collider) + t * velocity,
        product(rotation_matrix(t * spin), _rotation(collider)),
        velocity,
        spin,
    )


class _Leg(NamedTuple):
    """Hold the way from one keyframe to the next, which takes `span` [s]: a displacement, and a turn."""

    t: float
    span: float
    position: Array
    rotation: Array
    displacement: Array
    angle: Array
    velocity: Array
    omega: Array


class _Path:
    """Know a collider's way along its keyframes; each leg is worked out once, the last pose is kept."""

    def __init__(self, collider: Collider) -> None:
        self.collider = collider
        self._times = [key.t for key in collider.keyframes]
        self._legs: dict[int, _Leg] = {}
        self._last: tuple[float, Pose] | None = None

    def at(self, t: float) -> Pose:
        last = self._last  # read once: other threads may ask for other times
        if last is None or last[0] != t:
            last = self._last = (t, self._pose(t))
        return last[1]

    def _pose(self, t: float) -> Pose:
        keys = self.collider.keyframes
        i = bisect_right(self._times, t) - 1
        if i < 0 or i == len(keys) - 1:
            key = keys[max(i, 0)]
            still = np.zeros(3)
            return Pose(_position(self.collider, key), _rotation(self.collider, key), still, still)
        leg = self._legs.get(i) or self._legs.setdefault(i, self._leg(keys[i], keys[i + 1]))
        share = (t - leg.t) / leg.span
        return Pose(
            leg.position + share * leg.displacement,
            product(rotation_matrix(share * leg.angle), leg.rotation),
            leg.velocity,
            leg.omega,
        )

    def _leg(self, a: Keyframe, b: Keyframe) -> _Leg:
        span = b.t - a.t
        x0, R0 = _position(self.collider, a), _rotation(self.collider, a)
        displacement = _position(self.collider, b) - x0
        angle = rotation_vector(product(_rotation(self.collider, b), R0.T))
        return _Leg(a.t, span, x0, R0, displacement, angle, displacement / span, angle / span)


_PATHS: dict[int, _Path] = {}
"""Paths of late, by the identity of their colliders, which they keep alive."""
MOST_PATHS = 256


def _path_of(collider: Collider) -> _Path:
    path = _PATHS.get(id(collider))
    if path is None:
        if len(_PATHS) >= MOST_PATHS:
            _PATHS.clear()
        path = _PATHS[id(collider)] = _Path(collider)
    return path


def _position(collider: Collider, key: Keyframe | None = None) -> Array:
    if key is not None and key.position is not None:
        return np.array(key.position)
    return np.array(collider.place)


def _rotation(collider: Collider, key: Keyframe | None = None) -> Array:
    vector = collider.turned if key is None or key.rotation is None else key.rotation
    R = rotation_matrix(np.radians(vector))
    return R if collider.facing is None else product(R, rotation_to_normal(np.array(collider.facing)))
