"""Choose the time step: fixed, or the largest that the snow's own speeds allow; never an unstable one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from neve._core import Report
    from neve.mpm.model import Model

Bound = Literal["wave", "speed", "solid", "strain", "fixed", "dt_max", "retry"]


class Choice(NamedTuple):
    """A time step dt [s] and what bound it."""

    dt: float
    bound: Bound


def largest(model: Model, report: Report) -> Choice:
    """Return the step that the scene allows: the longest good one, or the user's own ("fixed").

    A step of the user's that would be unstable is shortened to stable_step().
    """
    if model.numerics.dt == "auto":
        return longest_stable(model, report)
    dt, stable = float(model.numerics.dt), stable_step(model, report)
    return Choice(dt, "fixed") if dt <= stable else Choice(stable, "wave")


def stable_step(model: Model, report: Report) -> float:
    """Return the longest step in which no vibration of the snow grows [s], courant dx / max_p c_p.

    See `neve.mpm.model.stable_courant`.
    """
    return model.courant * model.numerics.dx / report.wave if report.wave > 0 else math.inf


def longest_stable(model: Model, report: Report) -> Choice:
    """Return the automatic step, the least of

        cfl dx / max_p(c_p + |v_p|),  courant dx / max_p c_p,  cfl dx / max |v_solid|,
        strain_max / max_p |grad v|_p,  L / (2 max_p -tr grad v_p),  dt_max

    c = sqrt(modulus V0 / m) with the largest acoustic modulus of the law in the present, hardened state, per
    particle (Sun, Shinar and Schroeder 2020 give the idea; each law's header the formula); grad v is that of
    the last step, |.| Frobenius, and L is `Model.max_compression`. The bound is "wave" or "speed", whichever
    is larger, "solid", so that no solid runs over snow before a node has met it, "strain" (either), or
    "dt_max".
    """
    numerics = model.numerics
    best = Choice(numerics.dt_max, "dt_max")
    if report.fastest * best.dt > numerics.cfl * numerics.dx:
        bound: Bound = "wave" if report.wave >= report.speed else "speed"
        best = Choice(numerics.cfl * numerics.dx / report.fastest, bound)
    if stable_step(model, report) < best.dt:
        best = Choice(stable_step(model, report), "wave")
    if model.solid_speed * best.dt > numerics.cfl * numerics.dx:
        best = Choice(numerics.cfl * numerics.dx / model.solid_speed, "solid")
    if report.strain_rate * best.dt > numerics.strain_max:
        best = Choice(numerics.strain_max / report.strain_rate, "strain")
    if report.compression_rate * best.dt > 0.5 * model.max_compression:
        best = Choice(0.5 * model.max_compression / report.compression_rate, "strain")
    return best


def fitted(dt: float, remaining: float) -> float:
    """Return the step that divides `remaining` [s] evenly and does not exceed dt: no sliver is left."""
    return remaining / max(1, math.ceil(remaining / dt * (1 - 1e-9)))
