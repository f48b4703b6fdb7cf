"""The stages of the step on one of several ranks: those of one rank, with the exchange between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from neve.mpm.step import Stages, on_lattice
from neve.ranks.domain import Domain
from neve.ranks.reports import grid_report_of_all, report_of_all

if TYPE_CHECKING:
    from neve._core import GridReport, Report


@dataclass(frozen=True, kw_only=True)
class RankStages(Stages):
    """Run the stages for the particles of this rank; all ranks run them together."""

    domain: Domain

    def refresh(self) -> Report:
        """Derive stress and speeds from the state."""
        return self._of_all(super().refresh())

    def sort(self, anew: bool = False) -> None:
        """Send particles to where they belong, sort those that are here, and lay out grid and halo.

        Errors: Blowup for a particle that has left the lattice.
        """
        if self.grid.current and not anew:
            return
        with self.timer.stage("sort"):
            with self.domain.world.any_error(), on_lattice(self.model):
                self.domain.find_owners(self.model, self.state)
            self.domain.migrate(self.state, self.grid)
            self.model.core.sort(self.model.native, self.state, self.grid)
            self.domain.after_sort(self.state, self.grid)

    def particles_to_grid(self, dt: float) -> None:
        """Scatter to the nodes, and add what other ranks give to them."""
        with self.timer.stage("p2g"):
            self.model.core.give(self.model.native, self.state, self.grid, dt)
            self.domain.exchange(self.grid)
        super().particles_to_grid(dt)

    def update_grid(self, dt: float) -> GridReport:
        """Turn momenta into velocities; nodes of several ranks in each, with the same bits."""
        if self.model.rigid is None:
            mine = super().update_grid(dt)
        else:
            with self.timer.stage("grid"):
                mine = self.domain.update_grid(self.model, self.grid, dt)
        return cast("GridReport", grid_report_of_all(self.domain.world, mine))

    def grid_to_particles(self, dt: float, commit: bool = True) -> Report:
        """Gather velocities and move the particles; all are sorted anew if one has left its block."""
        report = self._of_all(super().grid_to_particles(dt, commit))
        if commit and report.drifted:
            self.domain.unsort(self.grid)
        return report

    def _of_all(self, mine: Report) -> Report:
        return cast("Report", report_of_all(self.domain.world, mine))
