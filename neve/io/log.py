"""The log of a run: `log.csv`, one row for each frame, ready for a spreadsheet or pandas."""

from __future__ import annotations

import contextlib
import csv
import errno
import io
import math
import os
from collections.abc import Mapping
from pathlib import Path

from neve.io.atomic import write_text
from neve.io.errors import RunError, cannot_read, cannot_write
from neve.mpm import solver

STAGES = (*solver.STAGES, "write", "film")
"""Stages with a column of wall time [s] each: those of the step, then writing files and drawing the film."""

COLUMNS = (
    "frame",  # number of the frame; 0 is the initial state
    "time",  # simulated time [s]
    "steps",  # substeps since the start of the run
    "dt_min",  # smallest substep since the frame before [s]
    "dt_mean",  # mean substep since the frame before [s]
    "bound",  # what limited the smallest substep: wave, speed, fixed or dt_max
    "mass",  # [kg]
    "momentum_x",  # [kg m/s]
    "momentum_y",
    "momentum_z",
    "kinetic",  # energies [J]
    "elastic",
    "potential",
    "particles",
    "blocks",  # grid blocks of 4x4x4 nodes in use
    *(f"seconds_{stage}" for stage in STAGES),
)


class Log:
    """Append rows to a log, each with one write that is taken back if it fails.

    Errors: RunError if the disk refuses, or if the file has other columns (an older or newer Neve wrote it).
    """

    def __init__(self, path: Path, keep_through: int | None = None) -> None:
        """Start a new log, or keep the rows up to frame `keep_through` of the one that lies there."""
        self.path = path
        rows = []
        if keep_through is not None and path.exists():
            rows = [row for row in read_log(path) if int(row["frame"]) <= keep_through]
        write_text(path, "".join(_line(row) for row in [dict(zip(COLUMNS, COLUMNS, strict=True)), *rows]))

    def append(self, row: Mapping[str, object]) -> None:
        """Add one row; `row` has a value for every name in COLUMNS (None leaves the cell empty)."""
        data = _line({name: _cell(row[name]) for name in COLUMNS}).encode()
        try:
            with open(self.path, "ab", buffering=0) as file:
                end = file.seek(0, os.SEEK_END)
                try:
                    if file.write(data) != len(data):
                        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))  # a full disk takes a part
                    os.fsync(file.fileno())
                except BaseException:
                    with contextlib.suppress(OSError):
                        file.truncate(end)
                    raise
        except OSError as error:
            raise cannot_write(self.path, error) from error


def read_log(path: Path) -> list[dict[str, str]]:
    """Return the whole rows of a log as text, by column; a last line cut short by a crash is left out.

    Errors: RunError if the file cannot be read or has other columns.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise cannot_read(path, error) from error
    lines = text[: text.rfind("\n") + 1].splitlines()
    table = list(csv.reader(lines))
    if not table or tuple(table[0]) != COLUMNS:
        raise RunError(f"{path} is no log of this version of Neve; move it away or start anew with --force.")
    rows = [dict(zip(COLUMNS, cells, strict=True)) for cells in table[1:] if len(cells) == len(COLUMNS)]
    return [row for row in rows if row["frame"].isdecimal()]


def _line(row: Mapping[str, str]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerow([row[name] for name in COLUMNS])
    return buffer.getvalue()


def _cell(value: object) -> str:
    """Write a number so that it reads back as the same number, and None or NaN as an empty cell."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)
