"""The pieces of a run: `fragments.csv`, written during the run, or afterwards from its frames."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import NDArray

from neve.fragments import COLUMNS, LEAST, LINK, TORN, Fragments, Limits, find, rows
from neve.io.atomic import write_text
from neve.io.checkpoint import read_checkpoint
from neve.io.errors import RunError
from neve.io.frames import FOR_LIFE, Frame, Life, frame_numbers, read_frame
from neve.io.run_folder import RunFolder
from neve.io.table import read_table, table_text
from neve.registry import METHODS
from neve.run.outputs.context import FrameContext, RunContext, warn_of_lost
from neve.run.outputs.registry import entries, register_output, schedule_of
from neve.scene.schema.outputs import RESERVED, Scheduled
from neve.scene.values.fields import Real, Whole, entry
from neve.schedule import Schedule

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene

FILE = "fragments.csv"

NEEDED = ("id", "m", "V0")
"""Columns of the particles, besides those of a frame."""


class FragmentOptions(Scheduled):
    """Hold an entry with kind = "fragments"."""

    suffix = ".csv"

    kind: Literal["fragments"] = entry("fragments", "The pieces of broken snow, rows in a table.", "")
    name: str = entry(FILE, "Name of the table; ends in .csv.", "")
    link: Real = entry(LINK, "Gap that separates two pieces, in particle spacings.", "1", gt=0, le=100)
    torn: Real = entry(TORN, "J_P above which snow is torn open and holds nothing.", "1", gt=0, le=1e9)
    least: Whole = entry(LEAST, "Number of particles below which a piece counts as powder.", "1", ge=1)


@register_output("fragments", FragmentOptions, unasked=lambda scene: scene.run.fragments)
class FragmentOutput:
    """Write the rows of `fragments.csv`.

    In a resumed run, frames that have no rows (the switch was off) are counted from their files.
    """

    def __init__(self, name: str = FILE, link: float = LINK, torn: float = TORN, least: int = LEAST) -> None:
        self.name = name
        self._limits = Limits(link, torn, least)

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Start the table, or continue it after the rows of frame `done`."""
        _require_columns(run.scene)
        self._spacing = run.scene.numerics.spacing
        due = run.frames_done(schedule)
        is_known = run.inventory is not None and self.name in run.inventory.tables
        self._table = run.table(self.name, COLUMNS, due if is_known else ())
        self._have = {int(row["frame"]) for row in read_table(self._table.path, COLUMNS)} if due else set()
        self._lost = [frame for frame in due if not self._table.is_as_written or frame not in self._have]

    def resume(self, context: FrameContext) -> None:
        """Count frames that have no rows, or not those that were written, from their files."""
        gone, counted = [], []
        for frame in self._lost:
            content = self._content(context, frame)
            if content is not None:
                counted += self._rows(context, frame, content)
            elif frame not in self._have:
                gone.append(frame)
        if counted:
            self._table.replace(counted)
        warn_of_lost(self._table.path, gone)
        if counted and not gone and not self._table.is_as_written:
            logging.getLogger("neve").warning("%s is counted again from the frames", self._table.path)

    def write(self, context: FrameContext) -> None:
        """Add the rows of this frame."""
        with context.timer.stage("write"):
            self._table.append(*self._rows(context, context.frame, context.content))

    def close(self, context: FrameContext) -> None:
        """Do nothing: each row is complete."""

    def _content(self, context: FrameContext, frame: int) -> Frame | None:
        if frame == context.frame:
            return context.content
        try:
            return read_frame(context.run.folder.frames, frame)
        except RunError:
            return None

    def _rows(self, context: FrameContext, frame: int, content: Frame) -> list[dict[str, object]]:
        id, m, V0 = (context.sim.columns()[name]() for name in NEEDED)
        found = of_frame(content, id, m, V0, self._spacing, self._limits)
        return list(rows(found, frame, content.time))


def count_run(path: Path | str, limits: Limits | None = None, out: Path | None = None) -> Fragments:
    """Write `fragments.csv` of the run in the folder `path` from its frames; return those of the last frame.

    limits: what counts as a fragment; what a run uses by default
    out: the file, `fragments.csv` in the run folder by default

    Masses and volumes are those of the run's checkpoint: a particle keeps them for life. (With
    `numerics.initial_volume = "grid"` volumes are measured after frame 0; here it gets the measured ones.)

    Errors: RunError if the folder holds no run, no frames or no checkpoint, or the disk refuses.
    """
    from neve.scene.reading.load import load

    folder = RunFolder(path)
    if not folder.is_run():
        raise RunError(f"{folder.path} holds no Neve run, so there is nothing to count.")
    scene = load(folder.scene)
    _require_columns(scene)
    numbers = frame_numbers(folder.frames)
    target = out or folder.path / FILE
    inside = target.resolve().parent == folder.path.resolve()
    mine = _writer(scene, target.name) if inside else None
    others = {given.file() for given in entries(scene) if not isinstance(given, FragmentOptions)}
    if (mine is not None and limits is not None) or (inside and target.name in {*RESERVED, *others}):
        raise RunError(f"{target} belongs to the run: choose another file with --out.")
    if mine is not None:
        limits = Limits(mine.link, mine.torn, mine.least)
        schedule = schedule_of(mine, FragmentOutput(**mine.options()), scene.run.fps)
        due = [number for number in range(numbers[-1] + 1 if numbers else 0) if schedule.due(number)]
        if not set(due) <= set(numbers):
            raise RunError(
                f"{target} has rows of frames which the run keeps no files of:"
                " choose another file with --out."
            )
        numbers = due
    if not numbers:
        raise RunError(f"{folder.frames} holds no frames, so there is nothing to count.")
    arrays = read_checkpoint(folder.checkpoint).arrays
    table: list[dict[str, object]] = []
    for number in numbers:
        content = read_frame(folder.frames, number)
        found = of_frame(
            content, arrays["id"], arrays["m"], arrays["V0"], scene.numerics.spacing, limits or Limits()
        )
        table += rows(found, number, content.time)
    with folder.lock():
        write_text(target, table_text(COLUMNS, table))
    return found


def last_of(path: Path | str) -> Fragments:
    """Return the fragments of the last frame of the run in the folder `path`, and write nothing.

    Errors: RunError if the folder holds no frames or no checkpoint, or a method without J_P made them.
    """
    from neve.scene.reading.load import load

    folder = RunFolder(path)
    scene = load(folder.scene)
    _require_columns(scene)
    numbers = frame_numbers(folder.frames)
    if not numbers:
        raise RunError(f"{folder.frames} holds no frames, so there is nothing to count.")
    arrays = read_checkpoint(folder.checkpoint).arrays
    content = read_frame(folder.frames, numbers[-1])
    return of_frame(content, arrays["id"], arrays["m"], arrays["V0"], scene.numerics.spacing)


def of_frame(
    content: Frame,
    id: NDArray[Any],
    m: NDArray[Any],
    V0: NDArray[Any],
    spacing: float,
    limits: Limits = Limits(),  # noqa: B008 (a constant)
) -> Fragments:
    """Find the fragments of a frame, with the masses `m` [kg] and volumes `V0` [m3] of the particles `id`.

    A frame that holds m and V0 of its own is counted with these.
    Errors: RunError for a frame without J_P, or of other particles.
    """
    if content.J_P is None:
        raise RunError("this frame has no J_P, which tells torn snow from whole: it has no fragments.")
    if all(name in content.more for name in FOR_LIFE):
        mine = [content.more[name] for name in FOR_LIFE]
    else:
        life = Life(id, {"m": m, "V0": V0})
        mine = [life.of(name, content.id) for name in FOR_LIFE]
    return find(content.x, content.v, content.J_P, mine[0], mine[1], spacing, limits)


def _require_columns(scene: Scene) -> None:
    """Refuse a scene whose solver lacks what fragments are found from. Errors: RunError."""
    method = scene.numerics.method
    have = [field.name for field in METHODS.get(method).fields]
    if lacks := [name for name in (*NEEDED, "J_P") if name not in have]:
        raise RunError(f'numerics.method = "{method}" has no {" or ".join(lacks)}: drop the fragments.')


def _writer(scene: Scene, name: str) -> FragmentOptions | None:
    """Return the output of the run that writes the table `name`, if there is one."""
    return next(
        (given for given in entries(scene) if isinstance(given, FragmentOptions) and given.name == name), None
    )
