"""Say in one sentence why a run cannot go on: which particle, which snow, which quantity, what to change."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from neve import _core
from neve.mpm.model import Model
from neve.solver import Blowup

if TYPE_CHECKING:
    from neve._core import Report, State


def require_finite(model: Model, state: State, report: Report, steps: int, time: float, dt: float) -> None:
    """Raise Blowup if a pass found a value that is not finite."""
    if report.finite:
        return
    row = model.core.first_not_finite(state)
    when = f"after step {steps} (t = {time:.6g} s, dt = {dt:.3g} s)"
    if row < 0:
        raise Blowup(f"a particle has no finite stress {when}: {remedy(model)}")
    values = {"x": state.x[row], "v": state.v[row], "F_E": state.F_E[row], "J_P": state.J_P[row]}
    broken = [name for name, value in values.items() if not _finite(value)]
    raise Blowup(
        f"{name_of(model, state, row)} has no finite {' or '.join(broken) or 'stress'} {when}: "
        f"{remedy(model)}"
    )


def require_progress(model: Model, report: Report, dt: float, seconds: float, steps: int) -> None:
    """Raise Blowup if the time step has become so small that `seconds` [s] would never be over."""
    if dt > _core.shortest_share * seconds:
        return
    raise Blowup(
        f"after step {steps} waves run at {report.wave:.3g} m/s, snow moves at {report.speed:.3g} m/s "
        f"and deforms at {report.strain_rate:.3g} 1/s, which asks for a time step of {dt:.3g} s: raise "
        "snow.J_P_min, or lower snow.xi, snow.E0 or the velocities"
    )


def no_step(
    model: Model, state: State, report: Report, what: str, tried: int, steps: int, time: float, dt: float
) -> Blowup:
    """Return the Blowup of a step that was rejected `tried` times, the last time with dt [s], for `what`."""
    rows = np.flatnonzero(np.asarray(state.id) == report.offending_id)
    who = name_of(model, state, int(rows[0])) if len(rows) else "a particle"
    return Blowup(
        f"{who} {what} in step {steps + 1} (t = {time:.6g} s), even with a step {2 ** (tried - 1)} "
        f"times shorter (dt = {dt:.3g} s): {remedy(model)}"
    )


def remedy(model: Model) -> str:
    """Return what the user may change."""
    numerics = model.numerics
    if numerics.dt != "auto":
        return f'lower numerics.dt (now {numerics.dt:g} s) or set it to "auto"'
    return f"lower numerics.cfl (now {numerics.cfl:g}) or check E0, xi and velocities"


def name_of(model: Model, state: State, row: int) -> str:
    """Return which particle is at `row`: its number, its snow, its place."""
    material = int(state.material[row])
    law = f", {model.snows[material].law}" if material < len(model.snows) else ""
    where = ", ".join(f"{a:.4g}" for a in state.x[row])
    return f"particle {state.id[row]} (snow {material}{law}) at ({where}) m"


def _finite(value: object) -> bool:
    return bool(np.all(np.isfinite(np.asarray(value, dtype=np.float64))))
