"""The pieces of a run: `fragments.csv`, written while the run goes on, or afterwards from its frames."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.fragments import COLUMNS, Fragments, Limits, find, rows
from neve.io.atomic import write_text
from neve.io.checkpoint import read_checkpoint
from neve.io.errors import RunError
from neve.io.frames import Frame, frame_numbers, read_frame
from neve.io.run_folder import RunFolder
from neve.io.table import Table, read_table, table_text
from neve.schedule import EveryFrame, Schedule

if TYPE_CHECKING:
    from neve.run.outputs import FrameContext
    from neve.scene.schema.scene import Scene


class FragmentOutput:
    """Write the rows of `fragments.csv`.

    In a run that goes on, frames that have no rows (the switch was off) are counted from their files.
    """

    def __init__(self, folder: RunFolder, scene: Scene, done: int | None) -> None:
        """Start the table, or go on after the rows of frame `done`."""
        self.schedule: Schedule = EveryFrame()
        self._folder = folder
        self._spacing = scene.numerics.spacing
        kept = 0 if done is None else _kept(folder.fragments, done)
        self._lost = list(range(kept, 0 if done is None else done + 1))
        self._table = Table(folder.fragments, COLUMNS, keep_through=kept - 1 if kept else None)

    def write(self, context: FrameContext) -> None:
        """Add the rows of this frame."""
        with context.timer.stage("write"):
            self._add_lost(context)
            self._add(context, context.frame, context.content)

    def close(self, context: FrameContext) -> None:
        """Count what is still missing: a resumed run may be at its end already."""
        self._add_lost(context)

    def _add_lost(self, context: FrameContext) -> None:
        while self._lost:
            frame = self._lost.pop(0)
            self._add(context, frame, read_frame(self._folder.frames, frame))

    def _add(self, context: FrameContext, frame: int, content: Frame) -> None:
        state = context.sim.state
        found = of_frame(content, state.id, state.m, state.V0, self._spacing)
        self._table.append(*rows(found, frame, content.time))


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
    numbers = frame_numbers(folder.frames)
    if not numbers:
        raise RunError(f"{folder.frames} holds no frames, so there is nothing to count.")
    scene = load(folder.scene)
    if out is None and limits is not None and scene.run.fragments:
        raise RunError(f"{folder.fragments} belongs to the run: choose another file with --out.")
    arrays = read_checkpoint(folder.checkpoint).arrays
    table: list[dict[str, object]] = []
    for number in numbers:
        content = read_frame(folder.frames, number)
        found = of_frame(
            content, arrays["id"], arrays["m"], arrays["V0"], scene.numerics.spacing, limits or Limits()
        )
        table += rows(found, number, content.time)
    with folder.lock():
        write_text(out or folder.fragments, table_text(COLUMNS, table))
    return found


def of_frame(
    content: Frame,
    id: NDArray[Any],
    m: NDArray[Any],
    V0: NDArray[Any],
    spacing: float,
    limits: Limits = Limits(),  # noqa: B008 (a constant)
) -> Fragments:
    """Find the fragments of a frame, with the masses `m` [kg] and volumes `V0` [m3] of the particles `id`."""
    order = np.argsort(id)
    mine = order[np.searchsorted(id, content.id, sorter=order)]
    return find(content.x, content.v, content.J_P, m[mine], V0[mine], spacing, limits)


def _kept(path: Path, done: int) -> int:
    """Return how many frames, from the first on and up to `done`, have rows in the table at `path`."""
    if not path.exists():
        return 0
    have = {int(row["frame"]) for row in read_table(path, COLUMNS)}
    return next(frame for frame in range(done + 2) if frame not in have or frame > done)
