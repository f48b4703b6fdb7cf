"""What an earlier call of a sweep has left: rows that hold until their runs are looked at again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from neve.io.errors import RunError
from neve.run import last_frame
from neve.scene.schema.scene import Scene
from neve.sweep import spent
from neve.sweep.table import CSV, DONE, OWN, Row, read
from neve.sweep.task import Task


def known_rows(folder: Path) -> dict[str, Mapping[str, str]]:
    """Return the rows of the table in a folder by the names of the runs; none if it cannot be read."""
    if not (folder / CSV).exists():
        return {}
    try:
        return {row["run"]: row for row in read(folder)}
    except RunError:
        return {}


def begun(task: Task, before: Mapping[str, str] | None, scene: Scene) -> Row:
    """Return the row of a run until it has been looked at: as it was before if it was done, else waiting.

    before: its row in the table that was there
    """
    row = Row(task.name, task.point, seconds=task.seconds)
    found = spent.read(task.folder)
    if before is None or before["status"] != DONE or not found:
        return row
    if found.frame != last_frame(scene, task.frames):
        return row
    names = [*before]
    named = {measure.name for measure in task.measures}
    outputs = {
        name: _number(before[name])
        for name in names[names.index(OWN[-1]) + 1 :]
        if name in named or (task.functions and name not in task.point)
    }
    return Row(task.name, task.point, DONE, "", row.seconds, outputs)


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return math.nan
