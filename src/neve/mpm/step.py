"""The material point step for snow: Stomakhin et al. 2013, section 4.1."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from neve.mpm.failures import remedy
from neve.mpm.implicit import Implicit
from neve.mpm.model import Model
from neve.solver import Blowup
from neve.stage_timer import StageTimer

if TYPE_CHECKING:
    from neve._core import Grid, GridReport, Report, State, StepLimits

STAGES = ("stress", "sort", "p2g", "grid", "g2p", "ahead", "bodies")
"""Stages whose wall time is measured: `refresh`, the four lines of the step, steps that a GPU takes without
the host, of which nobody knows how long each line took, and solids and bodies."""


def step(on: Stages, dt: float, accepts: Callable[[GridReport], bool] = lambda report: True) -> Report | None:
    """Advance the particles by dt [s]: the ten stages of the paper, with its equation numbers.

    Stage 2, the initial volumes, is `Stages.measure_volumes`, once; stage 6 has nothing to solve in an
    explicit step, and is all of `update_grid` in an implicit one; stage 9, contact of particles, is done with
    the positions.

    accepts: asked after stage 6, when no particle has moved yet; if it says no, none is moved and there is no
    report (see neve.mpm.step_control).
    """
    on.sort()
    on.particles_to_grid(dt)  # 1: m_i = sum_p w_ip m_p, m_i v_i; 3: f_i = -sum_p V_p sigma_p grad w_ip, eq. 6
    report = on.update_grid(dt)  # 4: v_i* = v_i + dt f_i / m_i, eq. 10; 5: collisions, section 8; 6: implicit
    if not accepts(report):
        return None
    return on.grid_to_particles(dt)  # 7: F = (I + dt grad v) F, section 7; 8: v_p; 9: section 8; 10: x_p


@contextmanager
def on_lattice(model: Model) -> Iterator[None]:
    """Do what particles that have left the lattice forbid. Errors: Blowup in place of their ValueError."""
    try:
        yield
    except ValueError as error:
        reach = 2**22 * model.numerics.dx
        raise Blowup(
            f"{error}, which ends {reach:.4g} m from the origin: enlarge numerics.dx, or {remedy(model)}"
        ) from None


@dataclass(frozen=True)
class Stages:
    """Run the stages of the step on one model, state and grid, and time each of them.

    implicit: what finds the velocities of the nodes, unless their forces at the start of the step do
    """

    model: Model
    state: State
    grid: Grid
    timer: StageTimer
    implicit: Implicit | None = None

    def refresh(self) -> Report:
        """Derive stress and speeds from the state."""
        with self.timer.stage("stress"):
            return self.model.core.refresh(self.model.native, self.state)

    def sort(self, anew: bool = False) -> None:
        """Sort the particles and lay out the grid, if a particle has left its block or `anew` asks for it.

        Errors: Blowup for a particle that has left the lattice of 2^22 cells each way.
        """
        if self.grid.current and not anew:
            return
        with self.timer.stage("sort"), on_lattice(self.model):
            self.model.core.sort(self.model.native, self.state, self.grid)

    def particles_to_grid(self, dt: float) -> None:
        """Scatter mass, momentum and, in an explicit step, dt [s] times force to the nodes."""
        with self.timer.stage("p2g"):
            self.model.core.p2g(self.model.native, self.state, self.grid, 0.0 if self.implicit else dt)

    def update_grid(self, dt: float) -> GridReport:
        """Turn momenta into velocities after dt [s], with gravity and contact."""
        with self.timer.stage("grid"):
            if self.implicit:
                return self.implicit.solve(self.model, self.state, self.grid, dt)
            return self.model.core.grid_update(self.model.native, self.grid, dt)

    def grid_to_particles(self, dt: float, commit: bool = True) -> Report:
        """Gather velocities, deform and move the particles by dt [s]; without `commit` only report."""
        with self.timer.stage("g2p"):
            report = self.model.core.g2p(self.model.native, self.state, self.grid, dt, commit)
            if commit and self.implicit:
                self.implicit.finish(self.state)
            return report

    def run_ahead(
        self, limits: StepLimits, before: Report, seconds: float
    ) -> tuple[list[tuple[float, str]], Report] | None:
        """Let the device take steps of at most `seconds` [s] in all that it chooses and judges itself.

        Returns the dt of each [s] and what bound it, and the report of the last; None if it has taken none.
        The time of all their lines is that of the stage "ahead".
        """
        ahead = getattr(self.model.core, "run_ahead", None)
        if ahead is None:
            return None
        self.sort()
        with self.timer.stage("ahead"):
            taken, report = ahead(self.model.native, self.state, self.grid, limits, before, seconds)
        return (taken, report) if taken else None

    def measure_volumes(self) -> None:
        """Take each particle's rest volume from the density on the grid (stage 2): V0_p = m_p / rho_p.

        rho_p = sum_i m_i w_ip / dx^3. Stomakhin et al. 2013, section 4.1, step 2.
        """
        self.sort(anew=True)
        self.particles_to_grid(0.0)
        with self.timer.stage("stress"):
            self.model.core.volumes_from_grid(self.model.native, self.state, self.grid)
