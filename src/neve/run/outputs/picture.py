"""The picture of a run: `preview.png`, its most telling frame."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from neve.diagnostics import number
from neve.io.atomic import write_png
from neve.io.frames import Frame, frame_numbers, read_frame
from neve.io.log import read_log
from neve.run.best import best_frame
from neve.run.outputs.context import FrameContext, RunContext
from neve.run.outputs.registry import register_output
from neve.run.painter import Painter
from neve.scene.schema.outputs import Need, OutputOptions, Sizes
from neve.scene.schema.scene import Camera
from neve.scene.values.fields import entry
from neve.schedule import Never, Schedule

FILE = "preview.png"
STILL_BYTES = 0.9e6
"""Of a picture; measured."""

ENERGIES = ("kinetic", "elastic", "potential")
"""Columns of the log whose sum tells how far the snow has come to rest, where the solver has them."""


class PictureOptions(OutputOptions):
    """Hold an entry with kind = "picture"."""

    suffix = ".png"

    kind: Literal["picture"] = entry(
        "picture",
        "A picture of the frame in which moving snow covers the most of it, over what the same snow did at "
        "the start; drawn at the end.",
        "",
    )
    name: str = entry(FILE, "Name of the file; ends in .png.", "")
    camera: Camera | None = entry(None, "Camera of this picture; left out: the scene's.", "")

    def need(self, sizes: Sizes, due: int) -> Need:
        """Return about the bytes of the picture."""
        return Need(STILL_BYTES, 1)


@register_output("picture", PictureOptions, unasked=lambda scene: True)
class PictureOutput:
    """Draw the most telling frame when the run is finished."""

    def __init__(self, name: str = FILE, camera: Camera | None = None) -> None:
        self.schedule: Schedule = Never()
        self.name = name
        self._camera = camera

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Prepare to draw."""
        self._painter = Painter(run.seen_from(self._camera), run.solids, run.threads, radius=run.radius)

    def write(self, context: FrameContext) -> None:
        """Do nothing: the telling frame is known only at the end."""

    def close(self, context: FrameContext) -> None:
        """Choose the frame and draw it."""
        folder, scene = context.run.folder, context.run.scene
        kept = frame_numbers(folder.frames)
        if not context.finished or not kept:
            return

        def read(frame: int) -> Frame:
            return read_frame(folder.frames, frame)

        frame = best_frame(kept, read, self._painter.fresh_shot())
        if frame is None:
            heated = scene.heat is not None
            rows = read_log(
                folder.log, scene.numerics.method, scene.is_open, heated, scene.numerics.is_implicit
            )
            wanted = telling_frame(rows) if rows else context.frame // 2
            frame = min(kept, key=lambda k: abs(k - wanted))
        draw_still(folder.path / self.name, self._painter, kept, frame, read)


def draw_still(
    path: Path, painter: Painter, kept: Sequence[int], frame: int, read: Callable[[int], Frame]
) -> None:
    """Draw the picture of a frame, of those that are `kept`, into the file `path`. Errors: RunError."""
    painter.look_back([k for k in kept if k < frame], read)
    write_png(path, painter.draw(read(frame)))


def telling_frame(rows: Sequence[Mapping[str, Any]]) -> int:
    """Return a frame soon after half of the energy that the run loses is lost, where no other stands out.

    Energy is kinetic + elastic + potential; only losses from frame to frame count, so that a blade that does
    work on the snow does not hide them. Snow that bursts loses most of it in the impact itself: a fifth of
    the remaining frames later the pieces are in flight. Without any loss it is the middle frame of the run.
    """
    frames = [int(row["frame"]) for row in rows]
    energy = [sum(number(row[name]) for name in ENERGIES if name in row) for row in rows]
    losses = [max(before - after, 0.0) for before, after in itertools.pairwise(energy)]
    lost = list(itertools.accumulate(losses))
    if not lost or not lost[-1] > 0.0:
        return frames[len(frames) // 2]
    half = next(k for k, value in enumerate(lost) if value >= 0.5 * lost[-1])
    return frames[half + 1 + (len(frames) - 2 - half) // 5]
