"""The stages of the step on the GPU: those of `neve._core.f32` and `f64`, under the same names."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.cuda.bodies import DeviceBodies
from neve.cuda.driver import Driver
from neve.cuda.errors import DriverError
from neve.cuda.grid import DeviceGrid, solids_of
from neve.cuda.layout import ALL_COLOURS, EXTREMES, decoded, step_of
from neve.cuda.model import DeviceModel
from neve.cuda.state import DeviceState
from neve.cuda.sums import DeviceTotals, Sums
from neve.solver import Blowup

if TYPE_CHECKING:
    from neve._core import Precision

PARTICLE_THREADS, HOME_THREADS, NODE_THREADS, SCAN_THREADS, WARP = 128, 128, 64, 256, 32
"""Threads of a block, as in `core/cuda/kernels.hpp`."""
_NOBODY = 0xFFFFFFFF


class DeviceReport(NamedTuple):
    """What g2p or refresh found; see `neve._core.Report`."""

    wave: float
    speed: float
    fastest: float
    strain_rate: float
    compression_rate: float
    max_displacement: float
    min_volume_ratio: float
    ice_room: float
    finite: bool
    drifted: bool
    offending_id: int


class DeviceGridReport(NamedTuple):
    """What grid_update found; see `neve._core.GridReport`."""

    speed: float
    max_velocity_difference: float
    max_velocity_change: float
    finite: bool


class CudaStages:
    """The objects and stages of one precision on a GPU. What is not of the step is the core's own."""

    def __init__(self, driver: Driver, core: Precision, precision: str, deterministic: bool = False) -> None:
        self._driver, self._core, self._precision = driver, core, precision
        self._deterministic = deterministic
        self._step = step_of(precision)()
        self._step.colour = ALL_COLOURS
        self._scratch = self.Grid()
        self._bodies = DeviceBodies(driver, deterministic)
        self._real = np.float32 if precision == "float32" else np.float64
        self._filled: dict[str, Any] = {}
        self._sums = Sums(driver, deterministic)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._core, name)

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
        self._launch(model, "scan_homes", min(grid.homes, 1), SCAN_THREADS)
        self._each(model, "place_particles", count)
        self._launch(model, "order_homes", grid.homes, PARTICLE_THREADS)
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
        return self._report(self._scratch, "refresh", stepped=False)

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
            self._launch(model, name, grid.homes, HOME_THREADS)
            return
        for self._step.colour in range(ALL_COLOURS):
            self._launch(model, name, grid.homes, WARP)
        self._step.colour = ALL_COLOURS

    def volumes_from_grid(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
        """Take each particle's rest volume from the density on the grid. Errors: ValueError."""
        self._prepare_sorted(model, state, grid, 0.0)
        self._launch(model, "measure_volumes", grid.homes, PARTICLE_THREADS)
        state.moved(("V0",))

    def grid_update(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> DeviceGridReport:
        """Turn momenta into velocities, with gravity and contact."""
        step = self._step
        self._constants(model, grid, dt)
        solids_of(model, grid, step)
        grid.begin_attempt()
        step.bodies.count = model.native.body_count
        if step.bodies.count:
            self._bodies.fill(step.bodies, grid.blocks)
        self._launch(model, "grid_update", grid.blocks, NODE_THREADS)
        if step.bodies.count:
            self._move_bodies(model, grid, dt)
        self._each(model, "report_nodes", grid.homes)
        results = self._results(grid, "grid")
        most = self._extremes(results)
        return DeviceGridReport(
            math.sqrt(most["node_speed"]),
            math.sqrt(most["node_difference"]),
            math.sqrt(3.0) * most["node_change"],
            not results["not_finite"],
        )

    def _move_bodies(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> None:
        """Let the snow of the blocks that wait and the bodies find their common velocities."""
        bodies, waiting = self._bodies, int(self._results(grid, "grid")["waiting"])

        def response(U: NDArray[np.float64]) -> NDArray[np.float64]:
            bodies.move(U)
            self._launch(model, "body_response", waiting, NODE_THREADS)
            return bodies.response()

        bodies.move(model.native.solve_bodies(dt, response))
        self._launch(model, "meet_bodies", waiting, NODE_THREADS)

    def g2p(
        self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float, commit: bool = True
    ) -> DeviceReport:
        """Deform and move the particles; without `commit` the state is left as it is. Errors: ValueError."""
        step = self._prepare_sorted(model, state, grid, dt)
        solids_of(model, grid, step)
        step.commit = int(commit)
        if commit and step.nodes.lift:
            self._launch(model, "gather_lift", grid.homes, PARTICLE_THREADS)
        self._launch(model, "g2p", grid.homes, PARTICLE_THREADS)
        report = self._report(grid, "g2p", stepped=True)
        if commit:
            state.moved(("x", "v", "C", "F_E", "tau", "J_P", "modes"))
            grid.current = grid.current and not report.drifted
            grid.accept_attempt()
        return report

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
        self._step.sums = self._sums.clear()
        self._each(model, name, state.count)

    # Sorting

    def _find_homes(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
        """Number the homes; a table that is too small is doubled."""
        step = self._step
        while True:
            step.results = grid.clear_results()
            grid.home_table.clear(step.sorting.homes, grid.counter("homes"))
            self._each(model, "find_homes", state.count)
            found = self._results(grid, "sort")
            if not found["full"]:
                break
            grid.home_table.capacity *= 4
        if found["lost"]:
            raise ValueError(self._lost(state, int(found["lost"]) ^ _NOBODY))
        grid.homes = int(found["homes"])
        grid.lightest = -self._extremes(found)["less_mass"] if state.count else 0.0

    @staticmethod
    def _lost(state: DeviceState, number: int) -> str:
        row = int(np.flatnonzero(np.asarray(state.id) == number)[0])
        where = ", ".join(f"{a:f}" for a in np.asarray(state.x)[row])
        return f"particle {number} at ({where}) m is beyond the lattice"

    def _sort_homes(self, model: DeviceModel, grid: DeviceGrid) -> None:
        sorting, run = self._step.sorting, 2
        while run // 2 < grid.homes:
            spans = [run - 1]
            while run >> (len(spans) + 1) > 0:
                spans.append(run >> (len(spans) + 1))
            for sorting.span in spans:
                self._each(model, "sort_homes", grid.homes)
            run *= 2

    def _find_blocks(self, model: DeviceModel, grid: DeviceGrid) -> None:
        """Number the blocks of nodes, and give them room."""
        step = self._step
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
        step = self._step
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
        step = self._step
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
        self._launch(model, name, -(-count // PARTICLE_THREADS), PARTICLE_THREADS)

    def _launch(self, model: DeviceModel, name: str, blocks: int, threads: int) -> None:
        try:
            self._driver.launch(model.kernels()[name], blocks, threads, self._step)
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

    @staticmethod
    def _extremes(results: dict[str, Any]) -> dict[str, float]:
        return dict(zip(EXTREMES, decoded(results["most"]).tolist(), strict=True))

    def _report(self, grid: DeviceGrid, stage: str, stepped: bool) -> DeviceReport:
        results = self._results(grid, stage)
        most = self._extremes(results)
        offender = int(results["offender"]) ^ _NOBODY if stepped else _NOBODY
        return DeviceReport(
            wave=most["wave"],
            speed=most["speed"],
            fastest=most["fastest"],
            strain_rate=math.sqrt(most["rate2"]),
            compression_rate=most["compression"],
            max_displacement=math.sqrt(most["displacement2"]),
            min_volume_ratio=-most["less_volume"] if most["wave"] or stepped else 1.0,
            ice_room=-most["less_ice_room"] if most["less_ice_room"] else math.inf,
            finite=not results["not_finite"],
            drifted=bool(results["drifted"]),
            offending_id=offender,
        )
