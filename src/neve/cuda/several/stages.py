"""The stages of the step on several GPUs: those of `CudaStages` on each, joined where domains meet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.cuda.driver import Driver
from neve.cuda.grid import DeviceGrid
from neve.cuda.layout import RESULTS, SHADES, SUMS
from neve.cuda.model import DeviceModel
from neve.cuda.several.exchange import Exchange
from neve.cuda.several.grid import DomainGrid, total_of_sums
from neve.cuda.several.migration import Migration
from neve.cuda.several.peers import Peers
from neve.cuda.several.state import DomainState
from neve.cuda.stages import STEPPED, CudaStages
from neve.cuda.state import DeviceState
from neve.cuda.steps import picture
from neve.cuda.steps.reports import grid_report_of, report_of
from neve.cuda.sums import DeviceTotals, densest_of, totals_of
from neve.domains.reports import NodeReport, ParticleReport
from neve.solver import Device, Quantised

if TYPE_CHECKING:
    from neve._core import Model, Precision

Parts = Iterator[tuple[CudaStages, DeviceModel, DeviceState, DeviceGrid]]


class DomainModel:
    """A model on several GPUs: the core's own, which all is asked of, and its tables on each."""

    def __init__(self, native: Model, dx: float, parts: Sequence[DeviceModel]) -> None:
        self.native, self.dx, self.parts = native, dx, parts

    def __getattr__(self, name: str) -> Any:
        return getattr(self.native, name)


class SeveralStages:
    """The objects and stages of one precision on several GPUs. What is not of the step is the core's own.

    The host waits for all GPUs after each stage that finds something, and chooses each step.
    """

    def __init__(
        self, drivers: Sequence[Driver], core: Precision, precision: str, deterministic: bool = False
    ) -> None:
        self._drivers, self._core, self._precision = tuple(drivers), core, precision
        self._deterministic = deterministic
        self._stages = [CudaStages(driver, core, precision, deterministic) for driver in drivers]
        self._peers = Peers(self._drivers)
        self._exchange = Exchange(self._stages, self._peers, precision)
        self._migration = Migration(self._stages, self._peers)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._core, name)

    @property
    def device(self) -> Device:
        """The GPUs, and what is free on all if each has as much as the one that has least."""
        names = [driver.name for driver in self._drivers]
        told = names[0] if len(set(names)) == 1 else " and ".join(names)
        free = min(driver.memory()[0] for driver in self._drivers)
        return Device(f"{len(names)} x {told}" if told == names[0] else told, len(names) * free)

    # Objects

    def Model(self, dx: float, *arguments: Any, **named: Any) -> DomainModel:
        """Make a model without snows and solids."""
        native = self._core.Model(dx, *arguments, **named)
        parts = [
            DeviceModel(driver, native, self._precision, self._deterministic) for driver in self._drivers
        ]
        return DomainModel(native, dx, parts)

    def State(
        self, count: int, more_modes: int = 0, sleeps: bool = False, heat: bool = False, fine: bool = False
    ) -> DomainState:
        """Make `count` particles at rest. Errors: DeviceError."""
        return DomainState(self._drivers, self._core.State(count, more_modes))

    def Grid(self) -> DomainGrid:
        """Make an empty grid."""
        return DomainGrid(self._drivers, self._precision, self._deterministic)

    # Stages

    def sort(self, model: DomainModel, state: DomainState, grid: DomainGrid) -> None:
        """Move particles to their domains, sort each, and lay out the grid.

        Errors: ValueError, DeviceError.
        """
        grid.current = False
        state.upload(model.dx)
        assert state.partition is not None
        self._migration.move(model.parts, state, grid)
        for stages, m, s, g in self._each(model, state, grid):
            stages.sort(m, s, g)
        state.moved()
        grid.lay_out(state.partition, self._peers)
        grid.count, grid.current = state.count, True

    def refresh(self, model: DomainModel, state: DomainState) -> ParticleReport:
        """Write the stress, and report."""
        state.upload(model.dx)
        for stages, m, s in zip(self._stages, model.parts, state.parts, strict=True):
            stages.start_refresh(m, s)
        return report_of(self._most([stages.scratch for stages in self._stages], "refresh"), stepped=False)

    def p2g(self, model: DomainModel, state: DomainState, grid: DomainGrid, dt: float) -> None:
        """Scatter mass, momentum and force to the nodes of all domains. Errors: ValueError."""
        self._require_sorted(state, grid)
        for stages, m, s, g in self._each(model, state, grid):
            stages.start_p2g(m, s, g, dt)
        scatter = self._exchange.scatter_in_order if self._deterministic else self._exchange.scatter
        scatter(model.parts, grid)

    def volumes_from_grid(self, model: DomainModel, state: DomainState, grid: DomainGrid) -> None:
        """Take each particle's rest volume from the density on the grid. Errors: ValueError."""
        for stages, m, s, g in self._each(model, state, grid):
            stages.volumes_from_grid(m, s, g)

    def grid_update(self, model: DomainModel, grid: DomainGrid, dt: float) -> NodeReport:
        """Turn momenta into velocities, with gravity and contact; a node of several domains in each."""
        each = list(zip(self._stages, model.parts, grid.parts, strict=True))
        for stages, m, g in each:
            stages.start_grid_update(m, g, dt)
        if model.native.body_count:
            self._move_bodies(model, grid, dt)
        for stages, m, g in each:
            stages.each(m, "report_nodes", g.homes)
        return grid_report_of(self._most(grid.parts, "grid"))

    def _move_bodies(self, model: DomainModel, grid: DomainGrid, dt: float) -> None:
        """Let the snow of all domains and the bodies find their common velocities."""
        waiting = [
            int(stages.found(g, "grid")["waiting"])
            for stages, g in zip(self._stages, grid.parts, strict=True)
        ]

        def let_move(name: str, U: NDArray[np.float64]) -> None:
            for stages, m, count in zip(self._stages, model.parts, waiting, strict=True):
                stages.let_bodies_move(m, name, count, U)

        def response(U: NDArray[np.float64]) -> NDArray[np.float64]:
            let_move("body_response", U)
            raw = [stages.bodies.raw() for stages in self._stages]
            return self._stages[0].bodies.response(total_of_sums(self._peers, raw, self._deterministic))

        let_move("meet_bodies", model.native.solve_bodies(dt, response))

    def g2p(
        self, model: DomainModel, state: DomainState, grid: DomainGrid, dt: float, commit: bool = True
    ) -> ParticleReport:
        """Deform and move the particles; without `commit` the state is left as it is. Errors: ValueError."""
        self._require_sorted(state, grid)
        for stages, m, s, g in self._each(model, state, grid):
            stages.start_g2p(m, s, g, dt, commit)
        report = report_of(self._most(grid.parts, "g2p"), stepped=True)
        if commit:
            state.moved(STEPPED)
            grid.current = grid.current and not report.drifted
            grid.accept_attempt(self._peers)
        return report

    # Passes over the state

    def totals(self, model: DomainModel, state: DomainState) -> DeviceTotals:
        """Add up the state as it stands, one domain after another."""
        found = self._sums("add_up", model, state)
        out = np.zeros((), SUMS)
        out["number"] = total_of_sums(self._peers, [each["number"] for each in found], self._deterministic)
        return totals_of(out, self._deterministic)

    def first_not_finite(self, state: DomainState) -> int:
        """Return the row with the lowest id that has a value that is not finite; -1 if there is none."""
        return self._core.first_not_finite(state.whole())

    def inspect(self, model: DomainModel, state: DomainState) -> tuple[int, str, int, float]:
        """Look for values that no snow has, and for the densest; the processor names what is wrong."""
        densest = [(-1, 0.0)]
        for part, sums in zip(state.parts, self._sums("inspect", model, state), strict=True):
            found = densest_of(sums)
            if found is None:
                return self._core.inspect(model.native, state.whole())
            if found[0] >= 0:
                densest.append((found[0] + part.first, found[1]))
        return (-1, "", *max(densest, key=lambda found: found[1]))

    def quantised(self, model: DomainModel, state: DomainState, value: str) -> Quantised | None:
        """Return positions and the values of a colour in 16 bits each; None for a colour it does not know."""
        if value not in SHADES:
            return None
        state.upload(model.dx)
        parts = list(zip(self._stages, model.parts, state.parts, strict=True))
        for stages, m, s in parts:
            picture.start_ends(stages, m, s, value)
        low, step = picture.ends(self._most([stages.scratch for stages in self._stages], "picture")["most"])
        words = [picture.start(stages, m, s, low, step) for stages, m, s in parts]
        counts = [s.count for s in state.parts]
        return picture.quantised(picture.read(self._stages, words, counts), low, step, state)

    def _sums(self, name: str, model: DomainModel, state: DomainState) -> list[Any]:
        """Return what a kernel has summed over the particles of each domain."""
        state.upload(model.dx)
        for stages, m, s in zip(self._stages, model.parts, state.parts, strict=True):
            stages.start_sums(name, m, s)
        return [stages.sums.read() for stages in self._stages]

    # What is found

    def _each(self, model: DomainModel, state: DomainState, grid: DomainGrid) -> Parts:
        return zip(self._stages, model.parts, state.parts, grid.parts, strict=True)

    @staticmethod
    def _require_sorted(state: DomainState, grid: DomainGrid) -> None:
        if not grid.current or grid.count != state.count:
            raise ValueError("the grid does not hold this state: call sort() first")

    def _most(self, grids: Sequence[DeviceGrid], stage: str) -> dict[str, Any]:
        """Return what a stage has found in all domains: maxima and flags, of which the larger counts."""
        names = [name for name in RESULTS.names or () if name != "most"]
        found = [stages.found(grid, stage) for stages, grid in zip(self._stages, grids, strict=True)]
        rows = [np.concatenate([each["most"], [np.uint64(each[name]) for name in names]]) for each in found]
        most = self._peers.most(rows)
        count = len(most) - len(names)
        return {"most": most[:count], **dict(zip(names, most[count:], strict=True))}
