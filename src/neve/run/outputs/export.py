"""Files for other tools during a run: what `neve export` writes, frame by frame."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from types import TracebackType
from typing import Annotated, Literal, Self

import numpy as np

from neve.export.axes import Up
from neve.export.folder import ExportFolder, stem
from neve.export.format import Format
from neve.export.moment import moment_of
from neve.export.registry import FORMATS
from neve.export.run import Choices
from neve.io.errors import RunError
from neve.io.frames import FOR_LIFE, Frame, Life, frame_path, read_frame
from neve.io.links import refuse_link
from neve.io.npz import mark_of
from neve.run.outputs.context import FrameContext, RunContext, warn_of_lost
from neve.run.outputs.registry import register_output
from neve.scene.schema.outputs import Scheduled
from neve.scene.values.fields import Real, entry
from neve.scene.values.kinds import OneOf
from neve.schedule import Schedule

USUAL = "usd"


class ExportOptions(Scheduled):
    """Hold an entry with kind = "export"."""

    kind: Literal["export"] = entry(
        "export", "Files that other tools open, in a folder of their own (docs/into_other_tools.md).", ""
    )
    to: Annotated[str, OneOf(FORMATS)] = entry(USUAL, f"Format. {FORMATS.meaning()}.", "")
    name: str = entry("", "Name of the folder; left out, that of the format.", "")
    fields: tuple[str, ...] | None = entry(None, "Fields of the particles; left out, those of a frame.", "")
    up: Up | None = entry(None, "Axis that points up; left out, what is usual for the format.", "")
    scale: Real = entry(1.0, "Units of the files in a metre.", "1", ge=1e-6, le=1e6)

    def file(self) -> str:
        """Return the name of the folder."""
        return self.name or self.to


@register_output("export", ExportOptions)
class ExportOutput:
    """Write the files of a frame into a folder of the run.

    In a resumed run, frames whose files are lost are exported from the frame files that the run keeps.
    """

    def __init__(
        self,
        to: str = USUAL,
        name: str = "",
        fields: Sequence[str] | None = None,
        up: Up | None = None,
        scale: float = 1.0,
    ) -> None:
        self._choices = Choices(to, None if fields is None else tuple(fields), up, scale)
        self.name = name or to
        self._format: Format | None = None
        self._open = False

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Look what a run that is resumed has exported. Errors: RunError."""
        if self._choices.format.whole:
            raise RunError(
                f"outputs: the format {self._choices.to} has all frames in one file, which cannot grow during"
                " a run: use neve export after it."
            )
        path = run.folder.path / self.name
        refuse_link(run.folder.path, path)
        self._run = run
        self._folder = ExportFolder(path)
        self._format = self._choices.format(self._choices.job(path, run.scene, run.solids, run.radius))
        self._due = run.frames_done(schedule)

    def resume(self, context: FrameContext) -> None:
        """Export what is lost of this frame and of those before it, as far as the run keeps frame files."""
        self._prepare(context)
        assert self._format is not None
        self._folder.drop_after(context.frame, self._format.names)
        self._recall()
        gone, life = [], self._life(context)
        for frame in self._due:
            mark = self._mark(frame)
            if self._folder.has(frame, mark, self._format.names(frame)):
                continue
            try:
                content = context.content if frame == context.frame else read_frame(self._frames, frame)
            except RunError:
                gone.append(frame)
            else:
                self._export(frame, content, life)
        warn_of_lost(self._folder.path, gone)

    def write(self, context: FrameContext) -> None:
        """Write the files of this frame."""
        with context.timer.stage("write"):
            self._prepare(context)
            life = self._life(context)
            context.take()
            context.beside(lambda: self._export(context.frame, context.content, life))

    def close(self, context: FrameContext) -> None:
        """Write what belongs to all frames."""
        self._finish()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, Exception):
            with contextlib.suppress(RunError):  # the first error is the one to report
                self._finish()

    def _prepare(self, context: FrameContext) -> None:
        """Open the folder, once there is a frame that tells which fields there are."""
        if self._open:
            return
        assert self._format is not None
        columns = context.sim.columns()
        known = [name for name in FOR_LIFE if name in columns]
        self._names = self._choices.names(context.content, known)
        self._frames = self._run.folder.frames
        if self._format.weighs and "m" not in known:
            raise RunError(f"outputs: the particles have no mass, which the format {self._choices.to} needs.")
        options = self._choices.options(self._names)
        names = (*self._format.names(0), *self._format.shared_names())
        self._folder.open(options, self._run.done is None, {stem(name) for name in names})
        self._folder.announce(self._format.shared_names())
        self._open = True

    def _life(self, context: FrameContext) -> Life | None:
        """Copy what particles keep for life, if the files have it."""
        assert self._format is not None
        columns = context.sim.columns()
        asked = [
            name for name in FOR_LIFE if name in columns and (name in self._names or self._format.weighs)
        ]
        if not asked:
            return None
        return Life(np.array(columns["id"]()), {name: np.array(columns[name]()) for name in asked})

    def _export(self, frame: int, content: Frame, life: Life | None) -> None:
        assert self._format is not None
        self._format.job.camera.see(content)
        axes = self._format.job.axes
        moment = moment_of(frame, content, axes, self._names, life, self._format.weighs)
        self._folder.announce(self._format.names(frame))
        self._format.write(moment)
        self._folder.add(frame, moment.time, self._mark(frame))

    def _recall(self) -> None:
        """Show a camera that follows something the frames that the run keeps."""
        assert self._format is not None
        for frame in self._due if self._format.job.camera.follows else ():
            with contextlib.suppress(RunError):
                self._format.job.camera.see(read_frame(self._frames, frame))

    def _mark(self, frame: int) -> int:
        """Return the mark of the frame file; 0 where the run keeps none."""
        try:
            return mark_of(frame_path(self._run.folder.frames, frame)) or 0
        except OSError:
            return 0

    def _finish(self) -> None:
        if self._open and self._format is not None:
            self._format.close(self._folder.times())
            self._folder.save()
