"""The looks of a run: `preview.mp4`, drawn frame by frame, and `preview.png`, its most telling frame."""

from __future__ import annotations

import contextlib
import functools
import itertools
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from neve.io.atomic import write_png
from neve.io.frames import Frame, read_frame
from neve.io.log import read_log
from neve.schedule import EveryFrame, Never, Schedule

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.io.run_folder import RunFolder
    from neve.render.preview import Preview
    from neve.run.outputs import FrameContext
    from neve.scene.schema.scene import Scene

SIZE = (1280, 720)
"""Width and height of film and picture [pixels]."""


class Painter:
    """Draw frames as they lie in the run folder, so that a film drawn later is the same film."""

    def __init__(self, scene: Scene, solids: Sequence[Solid], threads: int | None = None) -> None:
        self._scene = scene
        self._solids = solids
        self._threads = threads or 0

    @functools.cached_property
    def _preview(self) -> Preview:
        from neve.render.preview import Preview

        return Preview(self._scene, *SIZE, threads=self._threads)

    def draw(self, content: Frame) -> NDArray[np.uint8]:
        """Return the image of a frame, (height, width, 3)."""
        from neve.geometry.pose import Pose

        places = zip(self._solids, content.body_position, content.body_rotation, strict=True)
        bodies = [(solid, Pose.at_rest(position, rotation)) for solid, position, rotation in places]
        return self._preview.draw(content.x, bodies, J_P=content.J_P)


class FilmOutput:
    """Draw each frame into `preview.mp4`.

    What a stopped process has filmed is kept; frames that are lost, or all if camera or light have changed
    (`anew`), are drawn again from their files. In a `with` block an error leaves the film of what was done.
    """

    def __init__(
        self, folder: RunFolder, scene: Scene, painter: Painter, done: int | None, anew: bool = False
    ) -> None:
        from neve.render.film import Film

        self.schedule: Schedule = EveryFrame()
        self._folder = folder
        self._painter = painter
        earlier = 0 if done is None else done + 1
        self._film = Film(folder.film, scene.run.fps, SIZE, start=0 if anew else earlier)
        self._lost = list(range(earlier)) if anew else self._film.missing

    def write(self, context: FrameContext) -> None:
        """Add the frame to the film."""
        with context.timer.stage("film"):
            self._add_lost()
            self._film.add(self._painter.draw(context.content), index=context.frame)

    def close(self, context: FrameContext) -> None:
        """Finish the film file; a stopped run leaves the film of what is done."""
        self._add_lost()
        self._film.close(keep=not context.finished)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, Exception):
            with contextlib.suppress(RuntimeError):  # the first error is the one to tell
                self._film.close(keep=True)

    def _add_lost(self) -> None:
        while self._lost:
            frame = self._lost.pop(0)
            self._film.add(self._painter.draw(read_frame(self._folder.frames, frame)), index=frame)


class PictureOutput:
    """Draw `preview.png` when the run is finished."""

    def __init__(self, folder: RunFolder, painter: Painter) -> None:
        self.schedule: Schedule = Never()
        self._folder = folder
        self._painter = painter

    def write(self, context: FrameContext) -> None:
        """Do nothing: the telling frame is known only at the end."""

    def close(self, context: FrameContext) -> None:
        """Choose the frame by the log and draw it from its file."""
        if not context.finished:
            return
        frame = telling_frame(read_log(self._folder.log))
        image = self._painter.draw(read_frame(self._folder.frames, frame))
        write_png(self._folder.picture, image)


def telling_frame(rows: Sequence[Mapping[str, Any]]) -> int:
    """Return a frame soon after half of the energy that the run loses is lost: what became of the snow.

    Energy is kinetic + elastic + potential; only losses from frame to frame count, so that a blade that does
    work on the snow does not hide them. Snow that bursts loses most of it in the impact itself: a fifth of
    the remaining frames later the pieces are in flight. Without any loss it is the middle frame of the run.
    """
    frames = [int(row["frame"]) for row in rows]
    energy = [sum(float(row[name]) for name in ("kinetic", "elastic", "potential")) for row in rows]
    losses = [max(before - after, 0.0) for before, after in itertools.pairwise(energy)]
    lost = list(itertools.accumulate(losses))
    if not lost or not lost[-1] > 0.0:
        return frames[len(frames) // 2]
    half = next(k for k, value in enumerate(lost) if value >= 0.5 * lost[-1])
    return frames[half + 1 + (len(frames) - 2 - half) // 5]
