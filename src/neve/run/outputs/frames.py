"""The frames of a run: `frames/NNNNNN.npz`."""

from __future__ import annotations

import logging
from typing import Literal

from neve.io.frames import frame_path
from neve.run.outputs.context import FrameContext, RunContext
from neve.run.outputs.registry import register_output
from neve.scene.schema.outputs import Need, Scheduled, Sizes
from neve.scene.values.fields import entry
from neve.schedule import Schedule


class FrameOptions(Scheduled):
    """Hold an entry with kind = "frames"."""

    kind: Literal["frames"] = entry("frames", "Particles and solids, in frames/NNNNNN.npz.", "")

    def file(self) -> str:
        """Return the name of the folder."""
        return "frames"

    def need(self, sizes: Sizes, due: int) -> Need:
        """Return the bytes of all files."""
        return Need(due * sizes.frame)


@register_output("frames", FrameOptions, unasked=lambda scene: True)
class FrameOutput:
    """Write `frames/NNNNNN.npz`."""

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Look which frames of a run that is resumed are not there, or not as they were written."""
        self._lost = [frame for frame in run.frames_done(schedule) if not run.is_as_written(frame)]

    def resume(self, context: FrameContext) -> None:
        """Write the last frame anew if it is lost, and tell what cannot be written again."""
        if context.frame in self._lost:
            context.run.write_frame(context.frame, context.stored)
            self._lost.remove(context.frame)
        if self._lost:
            more = f" and {len(self._lost) - 1} more" if len(self._lost) > 1 else ""
            logging.getLogger("neve").warning(
                "%s is gone or not as the run wrote it%s, and cannot be written again but by a new run",
                frame_path(context.run.folder.frames, self._lost[0]),
                more,
            )

    def write(self, context: FrameContext) -> None:
        """Write the frame."""
        with context.timer.stage("write"):
            context.take()
            context.beside(lambda: context.run.write_frame(context.frame, context.stored))

    def close(self, context: FrameContext) -> None:
        """Do nothing: each frame is complete."""
