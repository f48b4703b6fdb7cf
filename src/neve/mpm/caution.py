"""Take a step only if it is safe: look at it first, refuse it, and try it again with a shorter dt.

A step is refused if a value would not be finite, if a particle would move by more than a cell, if
det(I + dt grad v) would fall below 0.05, on the way to turning the particle inside out, if dt |grad v| would
exceed four times numerics.strain_max, or if snow would be pressed so far that its hardening stores more
energy than the step's work (`Model.press_limit`). Nothing has been moved by then: the particles are as they
were, so that a refused step needs no copy of the state to go back to.

Most steps need no closer look. After the grid update the velocities of the nodes around a particle differ by
d = `max_velocity_difference` at most, and |grad v| <= sqrt(3) d / dx. For affine transfers row a of grad v is
D^-1 sum_i w_ip v_ia (x_i - x_p); with v_ia measured from the middle of its range, |v_ia| <= d_a / 2,
an entry is at most d_a / dx, since sum_i w_ip |x_i - x_p|_b <= sqrt(D). For gradients of weights an
entry is at most (d_a / 2) sum |w'| <= d_a / dx. It leaves out nodes lighter than a
thousandth of the lightest particle, so it is an estimate; the particles' own rates of the last step, which
lone particles keep, are looked at besides. Only when an estimate comes near a limit is g2p run once without
moving anything. How far snow will be pressed is judged by the last step alone: the first step of an impact
may overshoot that limit.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from neve.mpm.blowup import no_step
from neve.mpm.solver import step
from neve.mpm.time_step import longest_stable

if TYPE_CHECKING:
    from neve._core import Grid, GridReport, Report, State
    from neve.model import Model

MOST_TRIES = 24
"""So often a step is tried, each time with half the dt, before the run is given up."""

_SAFE_STRAIN = 0.5  # of dt |grad v|: (1 - 0.5)^3 = 0.125 of the volume is left, above the limit of 0.05
_SAFE_LEAP = 0.9  # [cells]


class Taken(NamedTuple):
    """A step that was taken: its report, its dt [s], and how often it was refused before."""

    report: Report
    dt: float
    refusals: int


def careful_step(
    model: Model,
    state: State,
    grid: Grid,
    dt: float,
    before: Report,
    seconds: dict[str, float],
    steps: int = 0,
    time: float = 0.0,
) -> Taken:
    """Advance the state by dt [s], or by less if that is what it takes.

    A refused step is tried again with the largest stable step of the last report, if dt was longer than
    that, then with half of that, a quarter, ...

    before: the report of the last step; seconds: wall time of each stage, added to; steps, time: where the
    run stands, for the sentence.

    Errors: Blowup after MOST_TRIES refusals.
    """

    for refusals in range(MOST_TRIES):
        bold = partial(is_bold, before=before, dt=dt, model=model)
        refuses = partial(is_too_much, dt=dt, model=model)
        report, done = step(model, state, grid, dt, seconds, bold, refuses)
        if done:
            return Taken(report, dt, refusals)
        dt *= 0.5
        if refusals == 0:
            dt = min(dt, longest_stable(model, before).dt)
    raise no_step(model, state, report, MOST_TRIES, steps, time, 2.0 * dt)


def is_bold(ahead: GridReport, before: Report, dt: float, model: Model) -> bool:
    """Tell whether a step of dt [s] might have to be refused.

    A particle moves with a mean of node velocities, or, in transfers that blend FLIP in, with its own
    velocity and a mean of the nodes' changes.
    """
    per_cell = dt / model.numerics.dx
    strain = max(math.sqrt(3.0) * ahead.max_velocity_difference * per_cell, before.strain_rate * dt)
    press = before.compression_rate * dt
    leap = max(ahead.speed, before.speed + ahead.max_velocity_change) * per_cell
    calm = (
        strain <= min(_SAFE_STRAIN, 0.9 * _most_strain(model))
        and press <= 0.9 * model.press_limit
        and leap <= _SAFE_LEAP
    )
    return not (ahead.finite and calm)


def is_too_much(report: Report, dt: float, model: Model) -> bool:
    """Tell whether a step of dt [s] that was tried has to be refused."""
    strained = report.strain_rate * dt > _most_strain(model)
    return report.rejected or strained or report.compression_rate * dt > model.press_limit


def _most_strain(model: Model) -> float:
    return 4.0 * model.numerics.strain_max
