"""The step of Gissler et al. 2020, algorithm 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from neve.sph.constants import LARGEST, MOST_PRESSURE, MOST_SHEAR, TOLERANCE
from neve.stage_timer import StageTimer

if TYPE_CHECKING:
    from neve._core import Model as CoreModel
    from neve._core import SolveReport, Sph, SphReport

STAGES = ("neighbours", "densities", "friction", "pressure", "shear", "advance")
"""Names of the parts of a step."""


def prepare(snow: Sph, world: CoreModel, timer: StageTimer) -> None:
    """Find what a step of any length needs. Errors: ValueError with the birth number of a lost particle."""
    with timer.stage("neighbours"):
        snow.find_pairs(world)
    with timer.stage("densities"):
        snow.find_densities(world)  # rho_0, rho, lam, G
        snow.correct_gradients(world)  # L


@dataclass(frozen=True)
class Attempt:
    """An attempt at a step: how both solves ended, and the end of the step if both converged.

    refused: why nothing has moved; "" if the step was taken.
    """

    refused: str
    pressure: SolveReport
    shear: SolveReport | None = None
    end: SphReport | None = None


def attempt(snow: Sph, world: CoreModel, dt: float, way: float, strain: float, timer: StageTimer) -> Attempt:
    """Advance by dt [s], after `prepare`, or refuse to: nothing has moved then.

    way [m], strain [1]: how far a particle may move, and how large dt |grad v| may be.
    """
    with timer.stage("friction"):
        snow.find_given(world, dt)  # a_other, a_friction
    with timer.stage("pressure"):
        pressure = snow.solve_pressure(world, dt, TOLERANCE, LARGEST, MOST_PRESSURE)  # a_lambda
    if not pressure.converged:
        return Attempt(_unsolved("pressure", pressure), pressure)
    with timer.stage("shear"):
        shear = snow.solve_shear(dt, TOLERANCE, MOST_SHEAR)  # a_G
    if not shear.converged:
        return Attempt(_unsolved("shear", shear), pressure, shear)
    with timer.stage("advance"):
        end = snow.advance(world, dt, way, strain)  # v, F_E, x
    return Attempt("" if end.taken else _too_far(end, dt, way), pressure, shear, end)


def _unsolved(what: str, report: SolveReport) -> str:
    left = f"residual {report.residual:.2g}" + (f", {report.largest:.2g} at most" if report.largest else "")
    return f"{what} has not converged after {report.iterations} iterations ({left})"


def _too_far(end: SphReport, dt: float, way: float) -> str:
    if not end.finite:
        return "a particle would have no finite velocity"
    if end.speed * dt > way:
        return f"a particle would move by {end.speed * dt:.3g} m"
    return f"a particle would be strained by {end.strain_rate * dt:.2g}"
