"""The frames of a run: `frames/NNNNNN.npz`."""

from __future__ import annotations

from typing import Literal

from neve.io.frames import write_frame
from neve.run.outputs.context import FrameContext
from neve.run.outputs.registry import register_output
from neve.scene.schema.outputs import Scheduled
from neve.scene.values.fields import entry


class FrameOptions(Scheduled):
    """Hold an entry with kind = "frames"."""

    kind: Literal["frames"] = entry("frames", "Particles and solids, in frames/NNNNNN.npz.", "")

    def file(self) -> str:
        """Return the name of the folder."""
        return "frames"


@register_output("frames", FrameOptions, unasked=lambda scene: True)
class FrameOutput:
    """Write `frames/NNNNNN.npz`."""

    def write(self, context: FrameContext) -> None:
        """Write the frame."""
        with context.timer.stage("write"):
            write_frame(context.run.folder.frames, context.frame, context.content)

    def close(self, context: FrameContext) -> None:
        """Do nothing: each frame is complete."""
