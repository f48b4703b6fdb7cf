"""Choose the time step: fixed, or the largest that the snow's own speeds allow."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, NamedTuple

from neve.scene.scene import Numerics

if TYPE_CHECKING:
    from neve._core import Report

Bound = Literal["wave", "speed", "fixed", "dt_max"]


class Choice(NamedTuple):
    """A time step dt [s] and what bound it."""

    dt: float
    bound: Bound


def largest(numerics: Numerics, report: Report) -> Choice:
    """Return the largest step allowed: dt = cfl dx / max_p(c_p + |v_p|).

    c = sqrt((lam + 2 mu) V0 / m) with the hardened moduli, per particle (METHODS 8.7). The bound is "wave" or
    "speed", whichever is larger, "dt_max" if that is smaller still, or "fixed" for a step set by the user.
    """
    if numerics.dt != "auto":
        return Choice(float(numerics.dt), "fixed")
    if report.fastest * numerics.dt_max <= numerics.cfl * numerics.dx:
        return Choice(numerics.dt_max, "dt_max")
    return Choice(
        numerics.cfl * numerics.dx / report.fastest, "wave" if report.wave >= report.speed else "speed"
    )


def fitted(dt: float, remaining: float) -> float:
    """Return the step that divides `remaining` [s] evenly and does not exceed dt: no sliver is left."""
    return remaining / max(1, math.ceil(remaining / dt * (1 - 1e-9)))
