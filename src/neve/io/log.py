"""The log of a run: `log.csv`, one row for each frame, ready for a spreadsheet or pandas."""

from __future__ import annotations

from pathlib import Path

from neve.io.table import read_table
from neve.registry import METHODS

CLOCK = (
    "frame",  # number of the frame; 0 is the initial state
    "time",  # simulated time [s]
    "steps",  # substeps since the start of the run
    "dt_min",  # smallest substep since the frame before [s]
    "dt_mean",  # mean substep since the frame before [s]
    "bound",  # what limited the smallest substep, in the solver's words
    "rejected",  # substeps that were rejected and tried again with a shorter one since the frame before
)
"""Columns that every run has first."""

OUTSIDE = ("write", "film")
"""Stages outside the step with a column of wall time [s] each: writing files and drawing the film."""


def stages(method: str) -> tuple[str, ...]:
    """Return the stages with a column of wall time [s] each: those of the step of `method`, then OUTSIDE."""
    return (*METHODS.get(method).stages, *OUTSIDE)


def columns(method: str) -> tuple[str, ...]:
    """Return the columns of the log of a run with `numerics.method`: CLOCK, the solver's own, the seconds."""
    return (*CLOCK, *METHODS.get(method).log_columns, *(f"seconds_{stage}" for stage in stages(method)))


def read_log(path: Path, method: str) -> list[dict[str, str]]:
    """Return the whole rows of the log of a run with `numerics.method` as text, by column.

    A last line cut short by a crash is left out. Errors: RunError if the file cannot be read, has other
    columns, or is damaged.
    """
    return read_table(path, columns(method))
