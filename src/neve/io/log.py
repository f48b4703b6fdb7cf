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


FLOW = (
    "emitted_mass",  # of all snow that emitters added so far [kg]
    "emitted_momentum_x",  # with which it came [kg m/s]
    "emitted_momentum_y",
    "emitted_momentum_z",
    "emitted_energy",  # kinetic and potential [J]
    "removed_mass",  # the same of what sinks took out, at that time
    "removed_momentum_x",
    "removed_momentum_y",
    "removed_momentum_z",
    "removed_energy",  # kinetic, affine, elastic and potential [J]
)
"""Columns of a run in which snow comes or goes, after the solver's own."""

HEAT = (
    "heat",  # of all snow, above that of ice at the melting point [J]
    "heat_taken",  # from air and sun since the start [J]
    "water",  # mass that is liquid [kg]
    "heat_speed",  # seconds of heat in a second of motion
)
"""Columns of a run with heat, after those."""

IMPLICIT = (
    "solve_iterations",  # mean of a step since the frame before, those of rejected steps too
    "solve_rounds",  # linear systems, likewise
    "solve_residual",  # largest share of all forces that a solution left over
    "solve_unsettled",  # share of steps whose contacts still changed when they were followed no more
)
"""Columns of a run with `numerics.integrator` other than "explicit", after those."""


def columns(
    method: str, is_open: bool = False, has_heat: bool = False, is_implicit: bool = False
) -> tuple[str, ...]:
    """Return the columns of the log of a run with `numerics.method`: CLOCK, the solver's own, the seconds.

    is_open: whether snow comes or goes during the run: then FLOW comes before the seconds; has_heat: whether
    the scene has [heat]: then HEAT does; is_implicit: whether its steps are: then IMPLICIT does
    """
    own = METHODS.get(method).log_columns
    more = (*(FLOW if is_open else ()), *(HEAT if has_heat else ()), *(IMPLICIT if is_implicit else ()))
    return (*CLOCK, *own, *more, *(f"seconds_{stage}" for stage in stages(method)))


def read_log(
    path: Path, method: str, is_open: bool = False, has_heat: bool = False, is_implicit: bool = False
) -> list[dict[str, str]]:
    """Return the whole rows of the log of a run with `numerics.method` as text, by column (see `columns`).

    A last line cut short by a crash is left out. Errors: RunError if the file cannot be read, has other
    columns, or is damaged.
    """
    return read_table(path, columns(method, is_open, has_heat, is_implicit))
