"""Push and grab snow with the pointer."""

from __future__ import annotations

from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.simulation import Simulation
from neve.viewer.protocol.commands import Touch

Array = NDArray[Any]

STALE = 0.4
"""Seconds after which a touch that no page renews ends: the page may have gone."""

MAX_SPEED = 8.0
"""Greatest speed of the pointer and of a solid that is dragged [m/s]."""

REACTION = 0.05
"""Time in which snow takes on the pointer's velocity, and a dragged solid reaches the pointer [s]."""


class VelocityTool:
    """Push or grab the snow near a point that a page moves.

    Between two pieces of simulation, dt apart, the velocity v of each particle within the radius R relaxes
    towards that of the point, u: v += w (1 - exp(-dt / REACTION)) (u - v) with w = (1 - d^2 / R^2)^2 at
    distance d. Pushing does so only where the point is faster along its own path; grabbing also pulls the
    snow towards the point, and so holds it up.
    """

    def __init__(self) -> None:
        self._touch: Touch | None = None
        self._since = 0.0

    def take(self, touch: Touch) -> None:
        """Take what a page asks for last."""
        self._touch, self._since = (None if touch.done else touch), monotonic()

    def act(self, sim: Simulation, dt: float) -> None:
        """Change velocities for a piece of `dt` [s]."""
        touch = self._touch
        if touch is None or monotonic() - self._since > STALE:
            return
        point: Array = np.array(touch.point)
        state = sim.state
        away = point - state.x
        square = np.einsum("ni,ni->n", away, away)
        near = np.flatnonzero(square < touch.radius**2)
        if not len(near):
            return
        weight = (1.0 - square[near] / touch.radius**2) ** 2 * -np.expm1(-dt / REACTION)
        u = limited(np.array(touch.velocity))
        v = state.v[near]
        if touch.tool == "grab":
            gap = (u + limited(away[near] / (4 * REACTION))) - v
        else:
            speed = float(np.linalg.norm(u))
            if speed < 1e-3:
                return
            direction = u / speed
            gap = np.maximum(speed - v @ direction, 0.0)[:, None] * direction
        state.v[near] = v + weight[:, None] * gap


def limited(velocity: Array) -> Array:
    """Return velocities [m/s] (3,) or (n, 3), none faster than MAX_SPEED."""
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    return np.asarray(velocity * np.minimum(1.0, MAX_SPEED / np.maximum(speed, 1e-9)))
