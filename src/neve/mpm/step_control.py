"""Control the step size: accept a step or reject it before a particle moves, and retry with a shorter dt.

A step is rejected if a value would not be finite, if a particle would move by more than a cell, if
det(I + dt grad v) would fall below 0.05, on the way to turning the particle inside out, if dt |grad v| would
exceed four times numerics.strain_max, if snow would be pressed so far that its hardening stores more
energy than the step's work (`Model.max_compression`), or if it would become so stiff that such a step were
a fifth longer than a stable one: soft snow that meets the stiffness of ice in a single long step (an implicit
step is stable at any length); and if the equations of an implicit step were not solved. Nothing
has been moved by then: the particles are as they were, so that a rejected step needs no copy of the state to
go back to.

Most steps need no trial. After the grid update the velocities of the nodes around a particle differ by
d = `max_velocity_difference` at most, and |grad v| <= sqrt(3) d / dx. For affine transfers row a of grad v is
D^-1 sum_i w_ip v_ia (x_i - x_p); with v_ia measured from the middle of its range, |v_ia| <= d_a / 2,
an entry is at most d_a / dx, since sum_i w_ip |x_i - x_p|_b <= sqrt(D). For gradients of weights an
entry is at most (d_a / 2) sum |w'| <= d_a / dx. It leaves out nodes lighter than a
thousandth of the lightest particle, so it is an estimate; the particles' own rates of the last step, which
lone particles keep, are looked at besides. Only when an estimate comes near a limit is g2p tried: run once
without moving anything. How far snow will be pressed is judged by the last step alone: the first step of an
impact may overshoot that limit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from neve import _core
from neve.mpm.failures import no_step
from neve.mpm.step import Stages, step
from neve.mpm.time_step import limits_of, longest_stable, rates_of, stable_step

if TYPE_CHECKING:
    from neve._core import GridReport, Report
    from neve.mpm.model import Model

MAX_TRIES = 24
"""Maximum attempts per step, each with half the dt of the one before; after them the run ends."""

_MOST_UNSTABLE = 1.2  # over the stable step of the state at its end


class AcceptedStep(NamedTuple):
    """A step that was taken: its report, its dt [s], and how many attempts were rejected before."""

    report: Report
    dt: float
    rejected: int


def try_step(on: Stages, dt: float, before: Report, steps: int = 0, time: float = 0.0) -> AcceptedStep:
    """Advance the state by dt [s], or by less if a step of dt is rejected.

    A rejected step is tried again with the largest stable step of the last report, if dt was longer than
    that, then with half of that, a quarter, ...

    before: the report of the last step; steps, time: where the run stands, for the error.

    Errors: Blowup after MAX_TRIES rejections.
    """
    for rejected in range(MAX_TRIES):
        attempt = _Attempt(on, dt, before)
        report = step(on, dt, attempt.is_accepted)
        if report is not None:
            return AcceptedStep(report, dt, rejected)
        dt *= 0.5
        if rejected == 0:
            dt = min(dt, longest_stable(on.model, before).dt)
    what = attempt.unsolved or rejects(attempt.report, 2.0 * dt, on.model)
    raise no_step(on.model, on.state, attempt.report, what, MAX_TRIES, steps, time, 2.0 * dt)


class _Attempt:
    """Judge one attempt at a step of dt [s].

    Attributes:
        report: of its trial, or of the last step without one
        unsolved: why there are no velocities to judge, "" if there are
    """

    def __init__(self, on: Stages, dt: float, before: Report) -> None:
        self._on, self._dt, self.report = on, dt, before
        self.unsolved = ""

    def is_accepted(self, grid_report: GridReport) -> bool:
        """Tell whether the particles may move, after a trial if the grid asks for one."""
        implicit = self._on.implicit
        if implicit and not implicit.converged:
            self.unsolved = implicit.failure
            return False
        if not needs_trial(grid_report, self.report, self._dt, self._on.model):
            return True
        self.report = self._on.grid_to_particles(self._dt, commit=False)
        return not rejects(self.report, self._dt, self._on.model)


def needs_trial(grid_report: GridReport, before: Report, dt: float, model: Model) -> bool:
    """Tell whether a step of dt [s] might have to be rejected, so that it must be tried first.

    A particle moves with a mean of node velocities, or, in transfers that blend FLIP in, with its own
    velocity and a mean of the nodes' changes.
    """
    return _core.needs_trial(
        limits_of(model),
        grid_report.speed,
        grid_report.max_velocity_difference,
        grid_report.max_velocity_change,
        grid_report.finite,
        rates_of(model, before),
        dt,
    )


def rejects(report: Report, dt: float, model: Model) -> str:
    """Say why a trial of a step of dt [s] must be rejected, by its report; "" if it need not."""
    if not report.finite:
        return "would have no finite value"
    if report.max_displacement > _core.displacement_limit:
        return f"would move by {report.max_displacement:.3g} cells"
    if report.min_volume_ratio < _core.volume_ratio_limit:
        return f"would be pressed to {max(report.min_volume_ratio, 0.0):.2g} of its volume"
    if report.strain_rate * dt > limits_of(model).largest_strain:
        return f"would be strained by {report.strain_rate * dt:.2g}"
    if report.compression_rate * dt > model.max_compression:
        return f"would be pressed by {report.compression_rate * dt:.2g}, at more than its work affords,"
    if dt > _MOST_UNSTABLE * stable_step(model, report):
        return f"would become so stiff that waves run at {report.wave:.3g} m/s"
    return ""
