"""The checkpoint of a run: `checkpoint`, all that an exact resume needs."""

from __future__ import annotations

import time
from typing import Literal

from neve.io.checkpoint import write_checkpoint
from neve.run.outputs.context import FrameContext, RunContext
from neve.run.outputs.registry import register_output
from neve.scene.schema.outputs import Need, Scheduled, Sizes
from neve.scene.values.fields import entry
from neve.schedule import EveryWallSeconds, Schedule
from neve.system import disk

SCENE_BYTES = 10e3
"""Of the scene in a checkpoint and beside it, and of what the run has written by then; about."""


class CheckpointOptions(Scheduled):
    """Hold an entry with kind = "checkpoint"."""

    kind: Literal["checkpoint"] = entry(
        "checkpoint",
        "All that a resume needs, in checkpoint; without a schedule every 3 s of wall time, or less often, "
        "up to every minute, where it would take more than a hundredth of the time. The end of a run always "
        "has one.",
        "",
    )

    def file(self) -> str:
        """Return the name of the file."""
        return "checkpoint"

    def need(self, sizes: Sizes, due: int) -> Need:
        """Return the bytes of the one that lies there at the end, with the scene in it."""
        return Need(sizes.state + SCENE_BYTES)


@register_output("checkpoint", CheckpointOptions, unasked=lambda scene: True, completes=True)
class CheckpointOutput:
    """Write `checkpoint` now and then and at the end, after all else of its frame."""

    def __init__(self) -> None:
        self.schedule = EveryWallSeconds(3.0, share=0.01, most=60.0)
        self._written: int | None = None
        self._last = 0  # job that writes it

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Take note of the checkpoint that is there already."""
        self._written = run.done

    def write(self, context: FrameContext) -> None:
        """Write the state as of this frame."""
        run, frame = context.run, context.frame
        with context.timer.stage("write"):
            run.beside.wait(self._last)  # no two states wait in memory
            start = time.monotonic()
            arrays, marks = context.sim.arrays(), run.marks()
            copying = time.monotonic() - start

            def write() -> None:
                start = time.monotonic()
                disk.sync_folder(run.folder.frames)
                path = run.folder.checkpoint
                write_checkpoint(path, frame, run.toml, run.neve, arrays, run.now(marks))
                self.schedule.took(copying + time.monotonic() - start)

            self._last = context.beside(write)
        self._written = frame

    def close(self, context: FrameContext) -> None:
        """Write the state unless it is there already."""
        if self._written != context.frame:
            self.write(context)
