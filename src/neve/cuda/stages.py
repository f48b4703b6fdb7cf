"""The stages of the step on the GPU: those of `neve._core.f32` and `f64`, under the same names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.cuda.driver import Driver
from neve.cuda.errors import DriverError
from neve.cuda.grid import DeviceGrid, solids_of
from neve.cuda.layout import ALL_COLOURS, step_of
from neve.cuda.model import DeviceModel
from neve.cuda.state import DeviceState
from neve.cuda.steps.ahead import RunAhead
from neve.cuda.steps.bodies import DeviceBodies
from neve.cuda.steps.reports import (
    NOBODY,
    DeviceGridReport,
    DeviceReport,
    extremes,
    grid_report_of,
    last_report,
    report_of,
)
from neve.cuda.sums import DeviceTotals, Sums
from neve.solver import Blowup, Device

if TYPE_CHECKING:
    from neve._core import Precision, Report, StepLimits

PARTICLE_THREADS, HOME_THREADS, NODE_THREADS, SCAN_THREADS, WARP = 128, 128, 64, 256, 32
"""Threads of a block, as in `core/cuda/kernels.hpp`."""
STEPPED = ("x", "v", "C", "F_E", "tau", "J_P", "modes")
"""What a step changes of the particles."""


class CudaStages:
    """The objects and stages of one precision on a GPU. What is not of the step is the core's own."""

    def __init__(self, driver: Driver, core: Precision, precision: str, deterministic: bool = False) -> None:
        self._driver, self._core, self._precision = driver, core, precision
        self._deterministic = deterministic
        self.step = step_of(precision)()
        self.step.colour = ALL_COLOURS
        self._scratch = self.Grid()
        self._bodies = DeviceBodies(driver, deterministic)
        self._ahead = RunAhead(driver, precision)
        self._real = np.float32 if precision == "float32" else np.float64
        self._filled: dict[str, Any] = {}
        self._sums = Sums(driver, deterministic)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._core, name)

    @property
    def device(self) -> Device:
        """The GPU and its memory."""
        return Device(self._driver.name, self._driver.memory()[0])

    # Objects

    def Model(self, *arguments: Any, **named: Any) -> DeviceModel:
        """Make a model without snows and solids."""
        return DeviceModel(
            self._driver, self._core.Model(*arguments, **named), self._precision, self._deterministic
        )

    def State(self, count: int, more_modes: int = 0) -> DeviceState:
        """Make `count` particles at rest. Errors: DeviceError."""
        return DeviceState(self._driver, self._core.State(count, more_modes))

    def Grid(self) -> DeviceGrid:
        """Make an empty grid."""
        return DeviceGrid(self._driver, self._precision, self._deterministic)

    # Stages

    def sort(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
        """Sort the particles by block and cell, and lay out the grid. Errors: ValueError, DeviceError."""
        state.upload()
        grid.current = False
        step, count = self._prepare(model, state, grid, 0.0), state.count
        grid.fill_sorting(step.sorting, count)
        self._find_homes(model, state, grid)
        step.home_count = grid.homes
        grid.fill_homes(step.nodes)
        self._sort_homes(model, grid)
        self._each(model, "rank_homes", grid.homes)
        self._each(model, "count_homes", count)
        self.launch(model, "scan_homes", min(grid.homes, 1), SCAN_THREADS)
        self._each(model, "place_particles", count)
        self.launch(model, "order_homes", grid.homes, PARTICLE_THREADS)
        for step.sorting.width, step.sorting.from_, step.sorting.to in state.each_column():
            self._each(model, "permute", count)
        state.fill(step.particles)
        state.moved()
        self._find_blocks(model, grid)
        grid.count, grid.current = count, True

    def refresh(self, model: DeviceModel, state: DeviceState) -> DeviceReport:
        """Write the stress, and report."""
        state.upload()
        self._prepare(model, state, self._scratch, 0.0)
        self._each(model, "refresh", state.count)
        state.moved(("tau",))
        return report_of(self._results(self._scratch, "refresh"), stepped=False)

    def p2g(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float) -> None:
        """Scatter mass, momentum and force to the nodes. Errors: ValueError."""
        step = self._prepare_sorted(model, state, grid, dt)
        for address in (step.nodes.node, step.nodes.change, step.nodes.lift):
            if address:
                self._driver.fill(address, 0, grid.node_bytes)
        self._scatter(model, "p2g", grid)
        if step.nodes.lift:
            self._scatter(model, "scatter_lift", grid)

    def _scatter(self, model: DeviceModel, name: str, grid: DeviceGrid) -> None:
        """Let all homes add to their nodes; in an order that is always the same if that is asked for.

        Homes of one colour share no nodes, and one warp makes the sums of a home one after another.
        """
        if not self._deterministic:
            self.launch(model, name, grid.homes, HOME_THREADS)
            return
        for self.step.colour in range(ALL_COLOURS):
            self.launch(model, name, grid.homes, WARP)
        self.step.colour = ALL_COLOURS

    def volumes_from_grid(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
        """Take each particle's rest volume from the density on the grid. Errors: ValueError."""
        self._prepare_sorted(model, state, grid, 0.0)
        self.launch(model, "measure_volumes", grid.homes, PARTICLE_THREADS)
        state.moved(("V0",))

    def grid_update(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> DeviceGridReport:
        """Turn momenta into velocities, with gravity and contact."""
        step = self.step
        self._constants(model, grid, dt)
        solids_of(model, grid, step)
        grid.begin_attempt()
        step.bodies.count = model.native.body_count
        if step.bodies.count:
            self._bodies.fill(step.bodies, grid.blocks)
        self.launch(model, "grid_update", grid.blocks, NODE_THREADS)
        if step.bodies.count:
            self._move_bodies(model, grid, dt)
        self._each(model, "report_nodes", grid.homes)
        return grid_report_of(self._results(grid, "grid"))

    def _move_bodies(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> None:
        """Let the snow of the blocks that wait and the bodies find their common velocities."""
        bodies, waiting = self._bodies, int(self._results(grid, "grid")["waiting"])

        def response(U: NDArray[np.float64]) -> NDArray[np.float64]:
            bodies.move(U)
            self.launch(model, "body_response", waiting, NODE_THREADS)
            return bodies.response()

        bodies.move(model.native.solve_bodies(dt, response))
        self.launch(model, "meet_bodies", waiting, NODE_THREADS)

    def g2p(
        self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float, commit: bool = True
    ) -> DeviceReport:
        """Deform and move the particles; without `commit` the state is left as it is. Errors: ValueError."""
        step = self._prepare_sorted(model, state, grid, dt)
        solids_of(model, grid, step)
        step.commit = int(commit)
        if commit and step.nodes.lift:
            self.launch(model, "gather_lift", grid.homes, PARTICLE_THREADS)
        self.launch(model, "g2p", grid.homes, PARTICLE_THREADS)
        report = report_of(self._results(grid, "g2p"), stepped=True)
        if commit:
            state.moved(STEPPED)
            grid.current = grid.current and not report.drifted
            grid.accept_attempt()
        return report

    # Several steps

    def run_ahead(
        self,
        model: DeviceModel,
        state: DeviceState,
        grid: DeviceGrid,
        limits: StepLimits,
        before: Report,
        seconds: float,
    ) -> tuple[list[tuple[float, str]], DeviceReport]:
        """Take steps of at most `seconds` [s] in all, as long as none of them needs the host.

        Returns the dt of each [s] and what bound it, and the report of the last; maybe none is taken. For
        solids that stand still. before: the report of the last step. Errors: ValueError, Blowup.
        """
        step = self._prepare_sorted(model, state, grid, 1.0)
        solids_of(model, grid, step)
        step.accepted = grid.begin_ahead()
        step.commit, step.bodies.count = 1, 0
        control = self._ahead.control(limits, model.native.device_blend, before, seconds)
        try:
            steps = self._ahead.take(self, model, grid, control)
        except DriverError as error:
            raise self._failed("p2g, grid or g2p", error) from None
        if steps:
            state.moved(STEPPED)
            grid.current = not control["drifted"]
            grid.end_ahead()
        return steps, last_report(control)

    def launch_step(self, model: DeviceModel, grid: DeviceGrid) -> None:
        """Start the stages of a step that the GPU judges itself."""
        has_lift = bool(self.step.nodes.lift)
        self._scatter(model, "p2g", grid)
        if has_lift:
            self._scatter(model, "scatter_lift", grid)
        self.launch(model, "grid_update", grid.blocks, NODE_THREADS)
        self._each(model, "report_nodes", grid.homes)
        self.launch(model, "judge_step", 1, PARTICLE_THREADS)
        if has_lift:
            self.launch(model, "gather_lift", grid.homes, PARTICLE_THREADS)
        self.launch(model, "g2p", grid.homes, PARTICLE_THREADS)

    # Passes over the state

    def totals(self, model: DeviceModel, state: DeviceState) -> DeviceTotals:
        """Add up the state as it stands."""
        self._sum_up("add_up", model, state)
        return self._sums.totals()

    def first_not_finite(self, state: DeviceState) -> int:
        """Return the row with the lowest id that has a value that is not finite; -1 if there is none."""
        return self._core.first_not_finite(state.whole())

    def inspect(self, model: DeviceModel, state: DeviceState) -> tuple[int, str, int, float]:
        """Look for values that no snow has, and for the densest; the processor names what is wrong."""
        self._sum_up("inspect", model, state)
        densest = self._sums.densest()
        return self._core.inspect(model.native, state.whole()) if densest is None else (-1, "", *densest)

    def _sum_up(self, name: str, model: DeviceModel, state: DeviceState) -> None:
        state.upload()
        self._prepare(model, state, self._scratch, 0.0)
        self.step.sums = self._sums.clear()
        self._each(model, name, state.count)

    # Sorting

    def _find_homes(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
        """Number the homes; a table that is too small is doubled."""
        step = self.step
        while True:
            step.results = grid.clear_results()
            grid.home_table.clear(step.sorting.homes, grid.counter("homes"))
            self._each(model, "find_homes", state.count)
            found = self._results(grid, "sort")
            if not found["full"]:
                break
            grid.home_table.capacity *= 4
        if found["lost"]:
            raise ValueError(self._lost(state, int(found["lost"]) ^ NOBODY))
        grid.homes = int(found["homes"])
        grid.lightest = -extremes(found)["less_mass"] if state.count else 0.0

    @staticmethod
    def _lost(state: DeviceState, number: int) -> str:
        row = int(np.flatnonzero(np.asarray(state.id) == number)[0])
        where = ", ".join(f"{a:f}" for a in np.asarray(state.x)[row])
        return f"particle {number} at ({where}) m is beyond the lattice"

    def _sort_homes(self, model: DeviceModel, grid: DeviceGrid) -> None:
        sorting, run = self.step.sorting, 2
        while run // 2 < grid.homes:
            spans = [run - 1]
            while run >> (len(spans) + 1) > 0:
                spans.append(run >> (len(spans) + 1))
            for sorting.span in spans:
                self._each(model, "sort_homes", grid.homes)
            run *= 2

    def _find_blocks(self, model: DeviceModel, grid: DeviceGrid) -> None:
        """Number the blocks of nodes, and give them room."""
        step = self.step
        while True:
            step.results = grid.clear_results()
            grid.block_table.clear(step.sorting.blocks, grid.counter("blocks"))
            self._each(model, "find_blocks", 8 * grid.homes)
            found = self._results(grid, "sort")
            if not found["full"]:
                break
            grid.block_table.capacity *= 4
        step.block_count = grid.blocks = int(found["blocks"])
        grid.fill_nodes(step.nodes, model.keeps_change, model.has_play)
        self._each(model, "link_homes", 8 * grid.homes)

    # What kernels are given

    def _prepare_sorted(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float) -> Any:
        if not grid.current or grid.count != state.count:
            raise ValueError("the grid does not hold this state: call sort() first")
        return self._prepare(model, state, grid, dt)

    def _prepare(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float) -> Any:
        """Fill the struct of the kernels, but for the solids and what sorting needs."""
        step = self.step
        if self._is_new("particles", (state, state.sorted)):
            state.fill(step.particles)
            step.particle_count = state.count
        step.snows, step.snow_count = model.snows()
        self._constants(model, grid, dt)
        return step

    def _is_new(self, part: str, given: Any) -> bool:
        """Whether a part of the struct has not been filled from this, and take it that it is now."""
        if self._filled.get(part) == given:
            return False
        self._filled[part] = given
        return True

    def _constants(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> None:
        step = self.step
        if self._is_new("constants", dt):
            step.constants[:] = np.frombuffer(model.constants(dt), self._real).tolist()
        if self._is_new("nodes", (grid, grid.homes, grid.blocks, grid.lightest)):
            step.home_count, step.block_count, step.lightest = grid.homes, grid.blocks, grid.lightest
            grid.fill_homes(step.nodes)
            grid.fill_nodes(step.nodes, model.keeps_change, model.has_play)
        step.results = grid.clear_results()

    # Launches and reports

    def _each(self, model: DeviceModel, name: str, count: int) -> None:
        """Start a kernel with a thread for each of `count` things."""
        self.launch(model, name, -(-count // PARTICLE_THREADS), PARTICLE_THREADS)

    def launch(self, model: DeviceModel, name: str, blocks: int, threads: int) -> None:
        """Start a kernel on so many blocks of threads. Errors: Blowup if one before it has failed."""
        try:
            self._driver.launch(model.kernels()[name], blocks, threads, self.step)
        except DriverError as error:
            raise self._failed(name, error) from None

    def _failed(self, stage: str, error: DriverError) -> Blowup:
        return Blowup(
            f"{self._driver.name} has failed in the stage {stage} ({error.name}): the run can be resumed "
            'from its last checkpoint, here or with numerics.device = "cpu"'
        )

    def _results(self, grid: DeviceGrid, stage: str) -> dict[str, Any]:
        """Return what a stage has found, when it is done. Errors: Blowup if it failed."""
        try:
            return grid.results()
        except DriverError as error:
            raise self._failed(stage, error) from None
