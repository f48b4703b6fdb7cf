"""The log of a run: `log.csv`, one row for each frame, ready for a spreadsheet or pandas."""

from __future__ import annotations

from pathlib import Path

from neve.io.table import Table, read_table
from neve.mpm import step

STAGES = (*step.STAGES, "write", "film")
"""Stages with a column of wall time [s] each: those of the step, then writing files and drawing the film."""

COLUMNS = (
    "frame",  # number of the frame; 0 is the initial state
    "time",  # simulated time [s]
    "steps",  # substeps since the start of the run
    "dt_min",  # smallest substep since the frame before [s]
    "dt_mean",  # mean substep since the frame before [s]
    "bound",  # what limited the smallest substep: wave, speed, solid, strain, fixed, dt_max or retry
    "rejected",  # substeps that were rejected and tried again with a shorter one since the frame before
    "mass",  # [kg]
    "momentum_x",  # [kg m/s]
    "momentum_y",
    "momentum_z",
    "kinetic",  # energies [J]
    "elastic",
    "potential",
    "affine",  # kinetic energy of the velocity field that each particle carries around itself
    "work",  # of the colliders on the snow since the start
    "bodies_momentum_x",  # of the bodies that snow moves [kg m/s]
    "bodies_momentum_y",
    "bodies_momentum_z",
    "bodies_kinetic",  # their energies [J]
    "bodies_potential",
    "excess",  # growth of energy since the frame before that nothing accounts for; negative: dissipated
    "particles",
    "blocks",  # grid blocks of 4x4x4 nodes in use
    *(f"seconds_{stage}" for stage in STAGES),
)


class Log(Table):
    """Append rows to a log.

    Errors: RunError if the disk refuses, or if the file has other columns (an older or newer Neve wrote it).
    """

    def __init__(self, path: Path, keep_through: int | None = None) -> None:
        """Start a new log, or keep the rows up to frame `keep_through` of the one that lies there."""
        super().__init__(path, COLUMNS, keep_through)


def read_log(path: Path) -> list[dict[str, str]]:
    """Return the whole rows of a log as text, by column; a last line cut short by a crash is left out.

    Errors: RunError if the file cannot be read or has other columns.
    """
    return read_table(path, COLUMNS)
