"""The explicit material point step for snow: Stomakhin et al. 2013, section 4.1."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from neve.model import Model
from neve.mpm.blowup import Blowup, remedy

if TYPE_CHECKING:
    from collections.abc import Callable

    from neve._core import Grid, GridReport, Report, State

STAGES = ("stress", "sort", "p2g", "grid", "g2p", "bodies")


def step(
    model: Model,
    state: State,
    grid: Grid,
    dt: float,
    seconds: dict[str, float],
    is_bold: Callable[[GridReport], bool] = lambda ahead: False,
    is_too_much: Callable[[Report], bool] = lambda report: False,
) -> tuple[Report, bool]:
    """Advance the state by dt [s]; add the time of each stage to `seconds`.

    If `is_bold`, asked after stage 6, says so, stages 7 to 10 are tried before they are taken; if
    `is_too_much` says so of the trial's report, that is all: no particle is moved, and the second of what is
    returned is False.

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
    ahead = core.grid_update(native, grid, dt)  # 4, 5, 6
    updated = perf_counter()
    trial = core.g2p(native, state, grid, dt, False) if is_bold(ahead) else None
    refused = trial is not None and is_too_much(trial)
    report = trial if refused and trial else core.g2p(native, state, grid, dt)  # 7, 8, 9, 10
    gathered = perf_counter()
    for stage, spent in zip(
        ("sort", "p2g", "grid", "g2p"),
        (sorted_ - started, scattered - sorted_, updated - scattered, gathered - updated),
        strict=True,
    ):
        seconds[stage] += spent
    return report, not refused


def sort(model: Model, state: State, grid: Grid) -> None:
    """Sort the particles and lay out the grid.

    Errors: Blowup for a particle that has left the lattice of 2^22 cells each way.
    """
    try:
        model.core.sort(model.native, state, grid)
    except ValueError as error:
        reach = 2**22 * model.numerics.dx
        raise Blowup(
            f"{error}, which ends {reach:.4g} m from the origin: enlarge numerics.dx, or {remedy(model)}"
        ) from None


def measure_volumes(model: Model, state: State, grid: Grid) -> None:
    """Take each particle's rest volume from the density on the grid (stage 2): V0_p = m_p / rho_p.

    rho_p = sum_i m_i w_ip / dx^3. Stomakhin et al. 2013, section 4.1, step 2.
    """
    sort(model, state, grid)
    model.core.p2g(model.native, state, grid, 0.0)
    model.core.volumes_from_grid(model.native, state, grid)
