"""Move solids to where they are dragged."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import Pose, rotation_matrix, rotation_vector
from neve.scene.errors import SceneError
from neve.simulation import Simulation
from neve.viewer.protocol.commands import Move
from neve.viewer.tools import edit
from neve.viewer.tools.velocity import REACTION, limited

Array = NDArray[Any]


class DragController:
    """Move dragged solids to their goals at finite velocities, so that they push the snow."""

    def __init__(self) -> None:
        self._goals: dict[str, Move] = {}

    def take(self, move: Move) -> None:
        """Take a new goal of a solid."""
        self._goals[move.name] = move

    def act(self, sim: Simulation, dt: float) -> None:
        """Set the motion of each dragged solid for the next piece of `dt` [s].

        A collider of a scene is at x0 + v t: x0 = x - v t puts it at x now. One that has arrived rests.
        """
        if not self._goals:
            return
        scene = sim.scene
        where = {solid.name: pose for solid, pose in sim.solids()}
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
            t = 0.0 if name.startswith("bodies.") else sim.time  # bodies begin where they are put
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
    goal_rotation = rotation_matrix(np.radians(goal.rotation))
    return rotation_vector(goal_rotation @ pose.rotation.T) / seconds
