"""Where bodies are and what the snow does to them: `bodies.csv`, rows for every solid in every frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from neve.geometry.pose import Pose, quaternion_of
from neve.io.run_folder import RunFolder
from neve.io.table import Table
from neve.schedule import EveryFrame, Schedule

if TYPE_CHECKING:
    from neve.run.outputs import FrameContext

COLUMNS = (
    "frame",  # number of the frame; 0 is the initial state
    "time",  # simulated time [s]
    "body",  # name of the body: colliders.0, bodies.1, robots.0.wheel_left
    *("x", "y", "z"),  # position of the body's own frame [m]
    *("rotation_w", "rotation_x", "rotation_y", "rotation_z"),  # unit quaternion from its axes to the world's
    *("velocity_x", "velocity_y", "velocity_z"),  # of the frame's origin [m/s]
    *("omega_x", "omega_y", "omega_z"),  # angular velocity [rad/s]
    *("force_x", "force_y", "force_z"),  # of the snow on the body, mean since the frame before [N]
    *("torque_x", "torque_y", "torque_z"),  # of the snow about the frame's origin, mean likewise [N m]
)
"""Columns of `bodies.csv`; all vectors in world axes."""


class BodyOutput:
    """Write the rows of `bodies.csv`: one for each solid of the scene in each frame."""

    def __init__(self, folder: RunFolder, done: int | None) -> None:
        """Start the table, or go on after the rows of frame `done`."""
        self.schedule: Schedule = EveryFrame()
        self._table = Table(folder.bodies, COLUMNS, keep_through=done)

    def write(self, context: FrameContext) -> None:
        """Add the rows of this frame."""
        with context.timer.stage("write"):
            self._table.append(*rows(context))

    def close(self, context: FrameContext) -> None:
        """Do nothing: each row is complete."""


def rows(context: FrameContext) -> Iterator[dict[str, object]]:
    """Yield the row of each solid of the simulation now; there is no mean force in the first frame."""
    sim = context.sim
    bodies = sim.bodies()
    duration = 1.0 / sim.scene.run.fps
    pushed = sim.stats.exchanged[:, :6] / duration if context.frame > 0 else np.full((len(bodies), 6), np.nan)
    for (solid, pose), push in zip(bodies, pushed, strict=True):
        values = [float(value) for value in (*_numbers(pose), *push)]
        yield {
            "frame": context.frame,
            "time": float(sim.time),
            "body": solid.name,
            **dict(zip(COLUMNS[3:], values, strict=True)),
        }


def _numbers(pose: Pose) -> Iterator[float]:
    for vector in (pose.position, quaternion_of(pose.rotation), pose.velocity, pose.omega):
        yield from vector
