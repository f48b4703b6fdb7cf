"""Choose the time step: fixed, or the largest that the snow's own speeds allow; never an unstable one.

The formulas are in `core/mpm/step_choice.hpp`, since a GPU chooses its steps itself.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, NamedTuple, cast

from neve import _core

if TYPE_CHECKING:
    from neve._core import Report
    from neve.mpm.model import Model

Bound = Literal["wave", "speed", "solid", "strain", "fixed", "dt_max", "retry"]


class Choice(NamedTuple):
    """A time step dt [s] and what bound it."""

    dt: float
    bound: Bound


def limits_of(model: Model) -> _core.StepLimits:
    """Return what the scene and its snow allow a step now."""
    numerics = model.numerics
    implicit = numerics.is_implicit
    return _core.StepLimits(
        dx=numerics.dx,
        cfl=numerics.cfl,
        courant=model.courant,
        strain_max=numerics.implicit_strain if implicit else numerics.strain_max,
        dt_max=numerics.dt_max,
        dt=0.0 if numerics.dt == "auto" else float(numerics.dt),
        max_compression=model.max_compression,
        solid_speed=model.solid_speed,
    )


def rates_of(model: Model, report: Report) -> _core.ParticleRates:
    """Return what the next step follows from: waves bind no implicit step."""
    implicit = model.numerics.is_implicit
    return _core.ParticleRates(
        0.0 if implicit else report.wave,
        report.speed,
        report.speed if implicit else report.fastest,
        report.strain_rate,
        report.compression_rate,
        report.ice_room,
    )


def largest(model: Model, report: Report) -> Choice:
    """Return the step that the scene allows: the longest good one, or the user's own ("fixed").

    A step of the user's that would be unstable is shortened to stable_step().
    """
    if model.numerics.dt == "auto":
        return longest_stable(model, report)
    return _choice(*_core.largest_step(limits_of(model), rates_of(model, report)))


def stable_step(model: Model, report: Report) -> float:
    """Return the longest step in which no vibration of the snow grows [s], courant dx / max_p c_p.

    See `neve.mpm.model.stable_courant`.
    """
    return _core.stable_step(limits_of(model), rates_of(model, report))


def longest_stable(model: Model, report: Report) -> Choice:
    """Return the automatic step, the least of

        cfl dx / max_p(c_p + |v_p|),  courant dx / max_p c_p,  cfl dx / max |v_solid|,
        strain_max / max_p |grad v|_p,  L / (2 max_p -tr grad v_p),  dt_max

    c = sqrt(modulus V0 / m) with the largest acoustic modulus of the law in the present, hardened state, per
    particle (Sun, Shinar and Schroeder 2020 give the idea; each law's header the formula); grad v is that of
    the last step, |.| Frobenius, and L is `Model.max_compression`. The bound is "wave" or "speed", whichever
    is larger, "solid", so that no solid runs over snow before a node has met it, "strain" (either), or
    "dt_max".

    In an implicit step c = 0, `implicit_strain` takes the place of strain_max, and snow that begins to fall
    moves by no more than cfl dx: g dt^2 + max_p |v_p| dt <= cfl dx.
    """
    choice = _choice(*_core.longest_stable(limits_of(model), rates_of(model, report)))
    numerics = model.numerics
    if not numerics.is_implicit:
        return choice
    g, v, way = math.hypot(*model.gravity), report.speed, numerics.cfl * numerics.dx
    fall = 2.0 * way / (v + math.sqrt(v * v + 4.0 * g * way)) if g > 0 else math.inf
    return choice if choice.dt <= fall else Choice(fall, "speed")


def _choice(dt: float, bound: str) -> Choice:
    return Choice(dt, cast("Bound", bound))


def fitted(dt: float, remaining: float) -> float:
    """Return the step that divides `remaining` [s] evenly and does not exceed dt: no sliver is left."""
    return _core.fitted(dt, remaining)
