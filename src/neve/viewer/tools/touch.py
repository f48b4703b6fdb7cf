"""Touch: push and grab snow with the pointer, and lead solids to where they are dragged."""

from __future__ import annotations

from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import Pose, rotation_matrix, rotation_vector
from neve.scene.errors import SceneError
from neve.simulation import Simulation
from neve.viewer.protocol.commands import Move, Touch
from neve.viewer.tools import edit

Array = NDArray[Any]

STALE = 0.4
"""Seconds after which a touch that no page renews ends: the page may have gone."""

FASTEST = 8.0
"""Greatest speed of a hand or of a solid that is dragged [m/s]."""

REACTION = 0.05
"""Seconds in which a hand brings the snow to its own speed, and a dragged solid reaches the pointer."""


class Hand:
    """Move the snow near a point with it.

    Between two pieces of simulation, dt apart, the velocity of each particle within the radius R comes nearer
    to the hand's: v += w (1 - exp(-dt / REACTION)) (u - v) with w = (1 - d^2 / R^2)^2 at distance d. To push
    is to do so only where the hand is faster along its own way; to grab is to pull inward and hold up too.
    """

    def __init__(self) -> None:
        self._touch: Touch | None = None
        self._since = 0.0

    def take(self, touch: Touch) -> None:
        """Follow what a page does."""
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
        hand = limited(np.array(touch.velocity))
        v = state.v[near]
        if touch.tool == "grab":
            gap = (hand + limited(away[near] / (4 * REACTION))) - v
        else:
            speed = float(np.linalg.norm(hand))
            if speed < 1e-3:
                return
            way = hand / speed
            gap = np.maximum(speed - v @ way, 0.0)[:, None] * way
        state.v[near] = v + weight[:, None] * gap


class Mover:
    """Lead dragged solids to their goals by giving them velocities, so that snow feels them move."""

    def __init__(self) -> None:
        self._goals: dict[str, Move] = {}

    def take(self, move: Move) -> None:
        """Follow what a page drags."""
        self._goals[move.name] = move

    def lead(self, sim: Simulation, dt: float) -> None:
        """Set the motion of each dragged solid for the next piece of `dt` [s].

        A collider of a scene is at x0 + v t: x0 = x - v t puts it at x now. One that has arrived rests.
        """
        if not self._goals:
            return
        scene = sim.scene
        where = {solid.name: pose for solid, pose in sim.bodies()}
        for name, goal in list(self._goals.items()):
            pose = where.get(name)
            if pose is None:
                del self._goals[name]
                continue
            velocity = limited((np.array(goal.position) - pose.position) / max(dt, REACTION))
            spin = _spin_to(pose, goal, max(dt, REACTION))
            if np.linalg.norm(velocity) * dt < 1e-6 and np.linalg.norm(spin) * dt < 1e-6:
                velocity, spin = np.zeros(3), np.zeros(3)
                if goal.done:
                    del self._goals[name]
            t = 0.0 if name.startswith("bodies.") else sim.time  # bodies begin where they are told
            start = rotation_matrix(t * spin).T @ pose.rotation
            rest = goal.model_copy(
                update={
                    "position": tuple(pose.position - t * velocity),
                    "rotation": None if goal.rotation is None else tuple(np.degrees(rotation_vector(start))),
                }
            )
            try:
                scene = edit.placed(scene, rest, tuple(velocity), tuple(spin))
            except SceneError:
                self._goals.pop(name, None)
        sim.change(scene)


def _spin_to(pose: Pose, goal: Move, seconds: float) -> Array:
    """Return the angular velocity [rad/s] that turns a body to its goal in so many seconds."""
    if goal.rotation is None:
        return np.zeros(3)
    wish = rotation_matrix(np.radians(goal.rotation))
    return rotation_vector(wish @ pose.rotation.T) / seconds


def limited(
    velocity: Array,
) -> Array:
    """Return velocities [m/s] (3,) or (n, 3), none faster than FASTEST."""
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    return np.asarray(velocity * np.minimum(1.0, FASTEST / np.maximum(speed, 1e-9)))
