"""The film of a run: `preview.mp4`, drawn frame by frame."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from neve.io.atomic import replacing, writing
from neve.io.errors import RunError
from neve.io.frames import Frame, frame_numbers, frame_path, read_frame, write_frame
from neve.io.npz import read_npz, write_npz
from neve.io.run_folder import parts_of
from neve.run.outputs.context import FrameContext, RunContext
from neve.run.outputs.registry import register_output
from neve.run.painter import Painter
from neve.scene.schema.outputs import Need, Scheduled, Sizes
from neve.scene.schema.scene import Camera
from neve.scene.values.fields import entry
from neve.schedule import Regular, Schedule
from neve.system import disk

if TYPE_CHECKING:
    from neve.render.film import Film

FILE = "preview.mp4"
PICTURE_BYTES = 40e3
"""Of a film for each picture; 12 to 75 thousand, measured."""
SLOWEST = Fraction(1, 1000)
"""Least rate of pictures that an MP4 file can hold [1/s]."""
SEEN = "seen.npz"
"""What the camera of an unfinished film has seen, where the run does not keep all frames."""
COPIES = 60
"""Frames that ffmpeg may still hold when a process is killed: a segment of `neve.render.film`."""


_Drawn = tuple[NDArray[np.uint8], dict[str, NDArray[Any]] | None]


class FilmOptions(Scheduled):
    """Hold an entry with kind = "film"."""

    suffix = ".mp4"

    kind: Literal["film"] = entry("film", "A film of the frames, which plays as fast as the snow moved.", "")
    name: str = entry(FILE, "Name of the file; ends in .mp4.", "")
    camera: Camera | None = entry(None, "Camera of this film; left out: the scene's.", "")

    def need(self, sizes: Sizes, due: int) -> Need:
        """Return about the bytes of the film, and its pictures."""
        return Need(due * PICTURE_BYTES, due)


@register_output("film", FilmOptions, unasked=lambda scene: scene.run.film)
class FilmOutput:
    """Draw frames into a film.

    What a stopped process has filmed is kept; frames that are lost, or all if camera or light have changed,
    are drawn again from their files. In a `with` block an error leaves the film of what was done.
    """

    _film: Film | None = None

    def __init__(self, name: str = FILE, camera: Camera | None = None) -> None:
        self.name = name
        self._camera = camera

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Start the film, or continue it after the frames up to `done`."""
        from neve.render.film import Film

        path, fps = run.folder.path / self.name, run.scene.run.fps
        rate = max(1 / schedule.interval(fps), SLOWEST) if isinstance(schedule, Regular) else fps
        self._painter = Painter(run.seen_from(self._camera), run.solids, run.threads, radius=run.radius)
        self._frames = _Frames(run.folder.frames, parts_of(path), path)
        earlier = run.frames_done(schedule)
        self._next = len(earlier)
        self._film = Film(path, rate, self._painter.size, start=0 if run.redraw else len(earlier))
        missing = range(len(earlier)) if run.redraw else self._film.missing
        self._lost = [(index, earlier[index]) for index in missing]
        self._look_back(earlier)

    def write(self, context: FrameContext) -> None:
        """Draw the frame and add it to the film.

        Where the processor takes the steps, all its threads draw before they go on: of a picture that was
        drawn beside the steps each of them would wait for those that share their core with it.
        """
        with context.timer.stage("film"):
            self._add_lost()
            context.take()
            drawn = None if context.run.scene.numerics.device != "cpu" else self._drawn(context.content)
            context.beside(lambda: self._film_frame(context, drawn))

    def _film_frame(self, context: FrameContext, drawn: _Drawn | None) -> None:
        image, seen = drawn or self._drawn(context.content)
        self._frames.keep(context.frame, lambda: context.content)
        assert self._film is not None
        self._film.add(image, index=self._next)
        self._next += 1
        if seen and self._frames.sparse:
            self._frames.write_seen(seen)

    def _drawn(self, content: Frame) -> _Drawn:
        """Return the picture of a frame, and what a camera that follows something has seen by then."""
        image, shot = self._painter.draw(content), self._painter.shot
        return image, shot.state() if shot.follows else None

    def close(self, context: FrameContext) -> None:
        """Finish the film file; a stopped run leaves the film of what is done."""
        self._add_lost()
        if self._film:
            self._film.close(keep=not context.finished or self._frames.sparse)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, Exception) and self._film:
            with contextlib.suppress(RuntimeError):  # the first error is the one to report
                self._film.close(keep=True)

    def _look_back(self, earlier: Sequence[int]) -> None:
        """Let a camera that follows something know the frames up to `done`."""
        if not self._painter.shot.follows or not earlier:
            return
        if (seen := self._frames.read_seen()) is not None:
            self._painter.shot.recall(seen)
        else:
            self._painter.look_back(earlier, self._frames.read)

    def _add_lost(self) -> None:
        while self._lost:
            index, frame = self._lost.pop(0)
            assert self._film is not None
            self._film.add(self._painter.draw(self._frames.read(frame)), index=index)


class _Frames:
    """Keep what lost pieces of the film are drawn from: the run's frames, or copies where it has none."""

    def __init__(self, frames: Path, copies: Path, film: Path) -> None:
        self._folder, self._copies, self._film = frames, copies, film

    @property
    def sparse(self) -> bool:
        """Whether the run keeps no file of some frame that was filmed."""
        return bool(frame_numbers(self._copies))

    def keep(self, frame: int, content: Callable[[], Frame]) -> None:
        """Copy the frame unless the run has its file; drop copies that are in complete pieces of the film."""
        if frame_path(self._folder, frame).exists():
            return
        with writing(self._copies):
            disk.make_folder(self._copies)
            write_frame(self._copies, frame, content())
            old = frame_numbers(self._copies)[: -2 * COPIES]
            disk.remove_files(self._copies, [frame_path(self._copies, number).name for number in old])

    def write_seen(self, seen: Mapping[str, NDArray[Any]]) -> None:
        """Keep what the camera has seen of frames that may be gone. Errors: RunError."""
        with replacing(self._copies / SEEN) as file:
            write_npz(file, seen)

    def read_seen(self) -> dict[str, NDArray[Any]] | None:
        """Return what `write_seen` has kept; None if there is nothing, or it is damaged."""
        try:
            return read_npz(self._copies / SEEN)
        except (OSError, ValueError):
            return None

    def read(self, frame: int) -> Frame:
        """Return the frame. Errors: RunError if the run keeps no file of it, and it is no recent one."""
        for folder in (self._folder, self._copies):
            if frame_path(folder, frame).exists():
                return read_frame(folder, frame)
        raise RunError(
            f"{self._film} needs frame {frame} again, which the run keeps no file of: resume with the camera,"
            " the light and the films of before, or start over with --force."
        )
