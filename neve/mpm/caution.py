"""Take a step only if it is safe: look at it first, refuse it, and try it again with a shorter dt.

A step is refused if a value would not be finite, if a particle would move by more than a cell, if
det(I + dt grad v) would fall below 0.05, on the way to turning the particle inside out, or if dt |grad v|
would exceed four times what the automatic step allows. Nothing has been moved by then: the particles are as
they were, so that a refused step needs no copy of the state to go back to.

Most steps need no closer look. After the grid update the velocities of the nodes around a particle differ by
`spread` at most, and |grad v| <= sqrt(3) spread / dx for both splines: row a of grad v is D^-1 sum_i w_ip
v_ia (x_i - x_p), and with v_ia measured from the middle of its range, |v_ia| <= spread_a / 2, its length is
at most sqrt(3) spread_a / dx, since sum_i w_ip |x_i - x_p|_b <= sqrt(D). Only when that bound comes near a
limit is g2p run once without moving anything.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from neve.mpm.blowup import no_step
from neve.mpm.solver import step
from neve.mpm.time_step import longest_stable

if TYPE_CHECKING:
    from neve._core import Ahead, Grid, Report, State
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

    A refused step is tried again with the largest stable step of the last report, if dt was longer than that,
    then with half of that, a quarter, ...

    before: the report of the last step; seconds: wall time of each stage, added to; steps, time: where the
    run stands, for the sentence.

    Errors: Blowup after MOST_TRIES refusals.
    """

    most_strain = 4.0 * model.strain_limit
    stable = longest_stable(model, before).dt
    for refusals in range(MOST_TRIES):
        bold = partial(is_bold, before=before, dt=dt, dx=model.numerics.dx, most_strain=most_strain)
        refuses = partial(is_too_much, dt=dt, most_strain=most_strain)
        report, done = step(model, state, grid, dt, seconds, bold, refuses)
        if done:
            return Taken(report, dt, refusals)
        dt = min(0.5 * dt, stable) if refusals == 0 else 0.5 * dt
    raise no_step(model, state, report, MOST_TRIES, steps, time, 2.0 * dt)


def is_bold(ahead: Ahead, before: Report, dt: float, dx: float, most_strain: float) -> bool:
    """Tell whether a step of dt [s] on a grid of dx [m] might have to be refused.

    A particle moves with a mean of node velocities, or, in transfers that blend FLIP in, with its own
    velocity and a mean of the nodes' changes.
    """
    strain = math.sqrt(3.0) * ahead.spread * dt / dx
    leap = max(ahead.speed, before.speed + ahead.change) * dt / dx
    return not (ahead.finite and strain <= min(_SAFE_STRAIN, 0.9 * most_strain) and leap <= _SAFE_LEAP)


def is_too_much(report: Report, dt: float, most_strain: float) -> bool:
    """Tell whether a step of dt [s] that was tried has to be refused."""
    return report.refused or report.strain_rate * dt > most_strain
