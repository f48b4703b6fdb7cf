"""Where solids are and what the snow does to them: `solids.csv`, a row for every solid in every frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from neve.geometry.pose import Pose, quaternion_of
from neve.run.outputs.context import FrameContext, RunContext
from neve.run.outputs.registry import register_output
from neve.scene.schema.outputs import Need, Scheduled, Sizes
from neve.scene.values.fields import entry
from neve.schedule import Schedule

FILE = "solids.csv"

COLUMNS = (
    "frame",  # number of the frame; 0 is the initial state
    "time",  # simulated time [s]
    "solid",  # its name: colliders.0, bodies.1, robots.0.wheel_left
    *("x", "y", "z"),  # position of the solid's own frame [m]
    *("rotation_w", "rotation_x", "rotation_y", "rotation_z"),  # unit quaternion from its axes to the world's
    *("velocity_x", "velocity_y", "velocity_z"),  # of the frame's origin [m/s]
    *("omega_x", "omega_y", "omega_z"),  # angular velocity [rad/s]
    *("force_x", "force_y", "force_z"),  # of the snow on the solid, mean since the frame before [N]
    *("torque_x", "torque_y", "torque_z"),  # of the snow about the frame's origin, mean likewise [N m]
)
"""Columns of `solids.csv`; all vectors in world axes."""


class SolidOptions(Scheduled):
    """Hold an entry with kind = "solids"."""

    kind: Literal["solids"] = entry(
        "solids", f"Where solids are and what the snow does to them, rows in {FILE}.", ""
    )

    def file(self) -> str:
        """Return the name of the file."""
        return FILE

    def need(self, sizes: Sizes, due: int) -> Need:
        """Return about the bytes of the table."""
        return Need((due + 1) * sizes.solids)


@register_output(
    "solids", SolidOptions, unasked=lambda scene: bool(scene.colliders or scene.bodies or scene.robots)
)
class SolidOutput:
    """Write the rows of `solids.csv`: one for each solid of the scene in each frame."""

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Start the table, or continue it after the rows of frame `done`."""
        self._table = run.table(FILE, COLUMNS, run.frames_done(schedule))

    def write(self, context: FrameContext) -> None:
        """Add the rows of this frame."""
        with context.timer.stage("write"):
            self._table.append(*rows(context))

    def close(self, context: FrameContext) -> None:
        """Do nothing: each row is complete."""


def rows(context: FrameContext) -> Iterator[dict[str, object]]:
    """Yield the row of each solid of the simulation now; there is no mean force in the first frame."""
    sim = context.sim
    solids = sim.solids()
    duration = 1.0 / sim.scene.run.fps
    pushed = sim.stats.exchanged[:, :6] / duration if context.frame > 0 else np.full((len(solids), 6), np.nan)
    for (solid, pose), push in zip(solids, pushed, strict=True):
        values = [float(value) for value in (*_numbers(pose), *push)]
        yield {
            "frame": context.frame,
            "time": float(sim.time),
            "solid": solid.name,
            **dict(zip(COLUMNS[3:], values, strict=True)),
        }


def _numbers(pose: Pose) -> Iterator[float]:
    for vector in (pose.position, quaternion_of(pose.rotation), pose.velocity, pose.omega):
        yield from vector
