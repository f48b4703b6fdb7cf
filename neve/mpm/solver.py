"""The explicit material point step for snow: Stomakhin et al. 2013, section 4.1."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from neve.model import Model

if TYPE_CHECKING:
    from neve._core import Grid, Report, State

STAGES = ("stress", "sort", "p2g", "grid", "g2p")


class Blowup(RuntimeError):
    """Say which particle lost its numbers, where, when, and what to change. One sentence."""


def step(model: Model, state: State, grid: Grid, dt: float, seconds: dict[str, float]) -> Report:
    """Advance the state by dt [s]; add the time of each stage to `seconds`.

    The ten stages of the paper: 1 particles to grid; 2 initial volumes (`measure_volumes`, once); 3 forces;
    4 grid velocities; 5 grid collisions; 6 no solve, since the step is explicit; 7 deformation, plastic flow
    and hardening; 8 particle velocities; 9 particle collisions; 10 positions.
    """
    core, native = model.core, model.native
    started = perf_counter()
    if not grid.current:
        sort(model, state, grid)
    sorted_ = perf_counter()
    core.p2g(native, state, grid, dt)  # 1, 3
    scattered = perf_counter()
    core.grid_update(native, grid, dt)  # 4, 5, 6
    updated = perf_counter()
    report = core.g2p(native, state, grid, dt)  # 7, 8, 9, 10
    gathered = perf_counter()
    for stage, spent in zip(
        ("sort", "p2g", "grid", "g2p"),
        (sorted_ - started, scattered - sorted_, updated - scattered, gathered - updated),
        strict=True,
    ):
        seconds[stage] += spent
    return report


def sort(model: Model, state: State, grid: Grid) -> None:
    """Sort the particles and lay out the grid.

    Errors: Blowup for a particle that has left the lattice of 2^22 cells each way.
    """
    try:
        model.core.sort(model.native, state, grid)
    except ValueError as error:
        reach = 2**22 * model.numerics.dx
        raise Blowup(
            f"{error}, which ends {reach:.4g} m from the origin: enlarge numerics.dx, or {_remedy(model)}"
        ) from None


def measure_volumes(model: Model, state: State, grid: Grid) -> None:
    """Take each particle's rest volume from the density on the grid (stage 2): V0_p = m_p / rho_p.

    rho_p = sum_i m_i w_ip / dx^3. Stomakhin et al. 2013, section 4.1, step 2.
    """
    sort(model, state, grid)
    model.core.p2g(model.native, state, grid, 0.0)
    model.core.volumes_from_grid(model.native, state, grid)


def require_finite(model: Model, state: State, report: Report, steps: int, time: float, dt: float) -> None:
    """Raise Blowup if a pass found a value that is not finite."""
    if report.finite:
        return
    row = model.core.first_not_finite(state)
    when = f"after step {steps} (t = {time:.6g} s, dt = {dt:.3g} s)"
    if row < 0:
        raise Blowup(f"a particle has no finite stress {when}: {_remedy(model)}")
    values = {"x": state.x[row], "v": state.v[row], "F_E": state.F_E[row], "J_P": state.J_P[row]}
    broken = [name for name, value in values.items() if not _finite(value)]
    where = ", ".join(f"{a:.4g}" for a in state.x[row])
    raise Blowup(
        f"particle {state.id[row]} (snow {state.material[row]}) at ({where}) m has no finite "
        f"{' or '.join(broken) or 'stress'} {when}: {_remedy(model)}"
    )


def require_progress(model: Model, report: Report, dt: float, seconds: float, steps: int) -> None:
    """Raise Blowup if the time step has become so small that `seconds` [s] would never be over."""
    if dt > 1e-9 * seconds:
        return
    raise Blowup(
        f"after step {steps} waves run at {report.wave:.3g} m/s and snow at {report.speed:.3g} m/s, which "
        f"asks for a time step of {dt:.3g} s: raise snow.J_P_min, or lower snow.xi, snow.E0 or the velocities"
    )


def _remedy(model: Model) -> str:
    numerics = model.numerics
    if numerics.dt != "auto":
        return f'lower numerics.dt (now {numerics.dt:g} s) or set it to "auto"'
    return f"lower numerics.cfl (now {numerics.cfl:g}) or check E0, xi and velocities"


def _finite(value: object) -> bool:
    return bool(np.all(np.isfinite(np.asarray(value, dtype=np.float64))))
