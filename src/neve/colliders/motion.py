"""Say where a collider is and how it moves at any time."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.geometry.pose import Pose, rotation_matrix, rotation_to_normal, rotation_vector
from neve.reproducible import product
from neve.scene.schema.scene import Collider, Keyframe

Array = NDArray[np.float64]


def pose(collider: Collider, t: float) -> Pose:
    """Return where `collider` is at time `t` [s] and how it moves.

    With keyframes: linear in position, constant rate of turn; at a keyframe the motion that follows counts;
    at rest before the first and from the last on. Otherwise constant velocity and spin from t = 0 on.
    """
    return Pose(*path_of(collider).at(t))


_PATHS: dict[int, tuple[Collider, _core.ScriptedPath]] = {}
"""Paths of late, by the identity of their colliders, which they keep alive."""
MOST_PATHS = 1024


def path_of(collider: Collider) -> _core.ScriptedPath:
    """Return the way of `collider`, which knows its pose at any time."""
    known = _PATHS.get(id(collider))
    if known is None:
        if len(_PATHS) >= MOST_PATHS:
            _PATHS.clear()
        known = _PATHS[id(collider)] = (collider, _path(collider))
    return known[1]


def _path(collider: Collider) -> _core.ScriptedPath:
    keys = collider.keyframes
    if not keys:
        at = _position(collider), _rotation(collider)
        legs = [_leg(0.0, 1.0, *at, np.array(collider.velocity), np.array(collider.spin))]
    else:
        between = [_between(collider, a, b) for a, b in pairwise(keys)]
        legs = [_rest(collider, keys[0]), *between, _rest(collider, keys[-1])]
    return _core.ScriptedPath(np.array([key.t for key in keys], np.float64), np.array(legs))


def _between(collider: Collider, a: Keyframe, b: Keyframe) -> Array:
    x0, R0 = _position(collider, a), _rotation(collider, a)
    turn = rotation_vector(product(_rotation(collider, b), R0.T))
    return _leg(a.t, b.t - a.t, x0, R0, _position(collider, b) - x0, turn)


def _rest(collider: Collider, key: Keyframe) -> Array:
    return _leg(key.t, 1.0, _position(collider, key), _rotation(collider, key), np.zeros(3), np.zeros(3))


def _leg(begin: float, span: float, position: Array, rotation: Array, way: Array, turn: Array) -> Array:
    """Return a leg from `begin` [s] on as the core has it: in `span` [s] a `way` [m] and a `turn` [rad]."""
    angle = math.hypot(*turn)
    axis = turn / angle if angle else turn
    parts = ([begin, span], position, rotation.ravel(), way, axis, [angle], way / span, turn / span)
    return np.concatenate(parts)


def _position(collider: Collider, key: Keyframe | None = None) -> Array:
    if key is not None and key.position is not None:
        return np.array(key.position)
    return np.array(collider.place)


def _rotation(collider: Collider, key: Keyframe | None = None) -> Array:
    vector = collider.turned if key is None or key.rotation is None else key.rotation
    R = rotation_matrix(np.radians(vector))
    return R if collider.facing is None else product(R, rotation_to_normal(np.array(collider.facing)))
