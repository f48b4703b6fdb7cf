"""The stages of the step on the GPU: those of `neve._core.f32` and `f64`, under the same names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from neve.cuda.driver import Driver
from neve.cuda.errors import DriverError
from neve.cuda.grid import DeviceGrid, solids_of
from neve.cuda.layout import ALL_COLOURS, SHADES, step_of
from neve.cuda.model import DeviceModel
from neve.cuda.state import DeviceState
from neve.cuda.steps import picture
from neve.cuda.steps.ahead import RunAhead
from neve.cuda.steps.bodies import DeviceBodies
from neve.cuda.steps.reports import (
    grid_report_of,
    last_report,
    report_of,
)
from neve.cuda.steps.sorting import sort
from neve.cuda.sums import DeviceTotals, Sums, densest_of, totals_of
from neve.domains.reports import NodeReport, ParticleReport
from neve.solver import Blowup, Device, Quantised

if TYPE_CHECKING:
    from neve._core import Precision, Report, StepLimits

PARTICLE_THREADS, HOME_THREADS, NODE_THREADS, WARP = 128, 128, 64, 32
"""Threads of a block, as in `core/cuda/kernels.hpp`."""
STEPPED = ("x", "v", "C", "F_E", "tau", "J_P", "modes")
"""What a step changes of the particles."""


class CudaStages:
    """The objects and stages of one precision on a GPU. What is not of the step is the core's own.

    Attributes:
        fused: whether one kernel gathers, and scatters for the next step: a variant, to be measured
    """

    fused: ClassVar[bool] = False

    def __init__(self, driver: Driver, core: Precision, precision: str, deterministic: bool = False) -> None:
        self.driver, self._core, self._precision = driver, core, precision
        self.deterministic = deterministic
        self.step = step_of(precision)()
        self.step.colour = ALL_COLOURS
        self.scratch = self.Grid()
        self.bodies = DeviceBodies(driver, deterministic)
        self._ahead = RunAhead(driver, precision)
        self._real = np.float32 if precision == "float32" else np.float64
        self._filled: dict[str, Any] = {}
        self.sums = Sums(driver)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._core, name)

    @property
    def device(self) -> Device:
        """The GPU and its memory."""
        return Device(self.driver.name, self.driver.memory()[0])

    # Objects

    def Model(self, *arguments: Any, **named: Any) -> DeviceModel:
        """Make a model without snows and solids."""
        return DeviceModel(
            self.driver,
            self._core.Model(*arguments, **named),
            self._precision,
            self.deterministic,
            self.fused,
        )

    def State(
        self, count: int, more_modes: int = 0, sleeps: bool = False, heat: bool = False, fine: bool = False
    ) -> DeviceState:
        """Make `count` particles at rest, none of which can sleep. Errors: DeviceError."""
        assert not sleeps, "the scene is checked"
        assert not heat, "the scene is checked"
        return DeviceState(self.driver, self._core.State(count, more_modes))

    def Grid(self) -> DeviceGrid:
        """Make an empty grid."""
        return DeviceGrid(self.driver, self._precision, self.deterministic)

    # Stages

    def sort(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
        """Sort the particles by block and cell, and lay out the grid. Errors: ValueError, DeviceError."""
        grid.current = False
        state.upload()
        sort(self, model, state, grid)

    def refresh(self, model: DeviceModel, state: DeviceState) -> ParticleReport:
        """Write the stress, and report."""
        state.upload()
        self.start_refresh(model, state)
        return report_of(self.found(self.scratch, "refresh"), stepped=False)

    def start_refresh(self, model: DeviceModel, state: DeviceState) -> None:
        """Start to write the stress; what is found is that of the grid `scratch`."""
        self.prepare(model, state, self.scratch, 0.0)
        self.each(model, "refresh", state.count)
        state.moved(("tau",))

    def p2g(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float) -> None:
        """Scatter mass, momentum and force to the nodes, unless g2p has done so. Errors: ValueError."""
        if grid.scattered:
            grid.take_next()
            return
        self.start_p2g(model, state, grid, dt)
        for name in self.scatters:
            self._scatter(model, name, grid)

    def start_p2g(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float) -> None:
        """Clear the nodes for what particles scatter. Errors: ValueError."""
        step = self._prepare_sorted(model, state, grid, dt)
        for address in (step.nodes.node, step.nodes.change, step.nodes.lift):
            if address:
                self.driver.fill(address, 0, grid.node_bytes)

    @property
    def scatters(self) -> tuple[str, ...]:
        """The kernels that scatter."""
        return ("p2g", "scatter_lift") if self.step.nodes.lift else ("p2g",)

    def _scatter(self, model: DeviceModel, name: str, grid: DeviceGrid) -> None:
        """Let all homes add to their nodes; in an order that is always the same if that is asked for.

        Homes of one colour share no nodes, and one warp makes the sums of a home one after another.
        """
        if not self.deterministic:
            self.launch(model, name, grid.homes, HOME_THREADS)
            return
        for colour in range(ALL_COLOURS):
            self.scatter_colour(model, name, grid, colour)

    def scatter_colour(self, model: DeviceModel, name: str, grid: DeviceGrid, colour: int) -> None:
        """Let the homes of one colour add to their nodes, each in a fixed order."""
        self.step.colour = colour
        self.launch(model, name, grid.homes, WARP)
        self.step.colour = ALL_COLOURS

    def scatter_some(self, model: DeviceModel, name: str, homes: tuple[int, int]) -> None:
        """Let some homes add to their nodes: the address of their numbers, and how many there are."""
        self.step.nodes.some, count = homes
        self.launch(model, name, count, HOME_THREADS)
        self.step.nodes.some = 0

    def volumes_from_grid(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid) -> None:
        """Take each particle's rest volume from the density on the grid. Errors: ValueError."""
        self._prepare_sorted(model, state, grid, 0.0)
        self.launch(model, "measure_volumes", grid.homes, PARTICLE_THREADS)
        state.moved(("V0",))

    def grid_update(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> NodeReport:
        """Turn momenta into velocities, with gravity and contact."""
        self.start_grid_update(model, grid, dt)
        if self.step.bodies.count:
            self._move_bodies(model, grid, dt)
        self.each(model, "report_nodes", grid.homes)
        return grid_report_of(self.found(grid, "grid"))

    def start_grid_update(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> None:
        """Start to do so, but for blocks that wait for bodies, which are counted."""
        step = self.step
        self._constants(model, grid, dt)
        solids_of(model, grid, step)
        grid.begin_attempt()
        step.bodies.count = model.native.body_count
        if step.bodies.count:
            self.bodies.fill(step.bodies, grid.blocks)
        self.launch(model, "grid_update", grid.blocks, NODE_THREADS)

    def _move_bodies(self, model: DeviceModel, grid: DeviceGrid, dt: float) -> None:
        """Let the snow of the blocks that wait and the bodies find their common velocities."""
        waiting = int(self.found(grid, "grid")["waiting"])

        def response(U: NDArray[np.float64]) -> NDArray[np.float64]:
            self.let_bodies_move(model, "body_response", waiting, U)
            return self.bodies.response(self.bodies.raw())

        self.let_bodies_move(model, "meet_bodies", waiting, model.native.solve_bodies(dt, response))

    def let_bodies_move(self, model: DeviceModel, name: str, waiting: int, U: NDArray[np.float64]) -> None:
        """Start a kernel for the blocks that wait, if bodies move with U (b, 6) [m/s, 1/s]."""
        self.bodies.move(U)
        self.launch(model, name, waiting, NODE_THREADS)

    def g2p(
        self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float, commit: bool = True
    ) -> ParticleReport:
        """Deform and move the particles; without `commit` the state is left as it is. Errors: ValueError."""
        self.start_g2p(model, state, grid, dt, commit)
        report = report_of(self.found(grid, "g2p"), stepped=True)
        if commit:
            state.moved(STEPPED)
            grid.current = grid.current and not report.drifted
            grid.scattered = model.is_fused and grid.current and report.finite
            grid.accept_attempt()
        return report

    def start_g2p(
        self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float, commit: bool
    ) -> None:
        """Start to do so."""
        step = self._prepare_sorted(model, state, grid, dt)
        solids_of(model, grid, step)
        step.commit = int(commit)
        if commit and step.nodes.lift:
            self.launch(model, "gather_lift", grid.homes, PARTICLE_THREADS)
        if not (commit and model.is_fused):
            self.launch(model, "g2p", grid.homes, PARTICLE_THREADS)
            return
        for address in (step.nodes.next, step.nodes.next_force):
            self.driver.fill(address, 0, grid.node_bytes)
        self.launch(model, "g2p2g", grid.homes, PARTICLE_THREADS)

    # Several steps

    def run_ahead(
        self,
        model: DeviceModel,
        state: DeviceState,
        grid: DeviceGrid,
        limits: StepLimits,
        before: Report,
        seconds: float,
    ) -> tuple[list[tuple[float, str]], ParticleReport]:
        """Take steps of at most `seconds` [s] in all, as long as none of them needs the host.

        Returns the dt of each [s] and what bound it, and the report of the last; maybe none is taken. For
        solids that stand still. before: the report of the last step. Errors: ValueError, Blowup.
        """
        if model.is_fused:  # one kernel of a step does what belongs to the next: the host chooses each
            return [], last_report(self._ahead.control(limits, (0.0, 0.0), before, seconds))
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
        for name in self.scatters:
            self._scatter(model, name, grid)
        self.launch(model, "grid_update", grid.blocks, NODE_THREADS)
        self.each(model, "report_nodes", grid.homes)
        self.launch(model, "judge_step", 1, PARTICLE_THREADS)
        if self.step.nodes.lift:
            self.launch(model, "gather_lift", grid.homes, PARTICLE_THREADS)
        self.launch(model, "g2p", grid.homes, PARTICLE_THREADS)

    # Passes over the state

    def totals(self, model: DeviceModel, state: DeviceState) -> DeviceTotals:
        """Add up the state as it stands."""
        state.upload()
        self.start_sums("add_up", model, state)
        return totals_of(self.sums.read(), self.deterministic)

    def first_not_finite(self, state: DeviceState) -> int:
        """Return the row with the lowest id that has a value that is not finite; -1 if there is none."""
        return self._core.first_not_finite(state.whole())

    def inspect(self, model: DeviceModel, state: DeviceState) -> tuple[int, str, int, float]:
        """Look for values that no snow has, and for the densest; the processor names what is wrong."""
        state.upload()
        self.start_sums("inspect", model, state)
        densest = densest_of(self.sums.read())
        return self._core.inspect(model.native, state.whole()) if densest is None else (-1, "", *densest)

    def quantised(self, model: DeviceModel, state: DeviceState, value: str) -> Quantised | None:
        """Return positions and the values of a colour in 16 bits each; None for a colour it does not know."""
        if value not in SHADES:
            return None
        state.upload()
        picture.start_ends(self, model, state, value)
        low, step = picture.ends(self.found(self.scratch, "picture")["most"])
        words = picture.start(self, model, state, low, step)
        return picture.quantised(picture.read([self], [words], [state.count]), low, step, state)

    def start_sums(self, name: str, model: DeviceModel, state: DeviceState) -> None:
        """Start to sum up the state by a kernel, into `sums`."""
        self.prepare(model, state, self.scratch, 0.0)
        self.step.sums = self.sums.clear()
        self.each(model, name, state.count)

    # What kernels are given

    def _prepare_sorted(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float) -> Any:
        if not grid.current or grid.count != state.count:
            raise ValueError("the grid does not hold this state: call sort() first")
        return self.prepare(model, state, grid, dt)

    def prepare(self, model: DeviceModel, state: DeviceState, grid: DeviceGrid, dt: float) -> Any:
        """Fill the struct of the kernels, but for the solids and what sorting needs."""
        step = self.step
        if self._is_new("particles", (state, state.sorted, state.count)):
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
        constants = model.constants(dt)  # gravity may follow keyframes
        if self._is_new("constants", constants):
            step.constants[:] = np.frombuffer(constants, self._real).tolist()
        if self._is_new("nodes", (grid, grid.homes, grid.blocks, grid.lightest, grid.ghosts, grid.turn)):
            step.home_count, step.block_count, step.lightest = grid.homes, grid.blocks, grid.lightest
            grid.fill_homes(step.nodes)
            grid.fill_nodes(step.nodes, model)
        step.results = grid.clear_results()

    # Launches and reports

    def each(self, model: DeviceModel, name: str, count: int) -> None:
        """Start a kernel with a thread for each of `count` things."""
        self.launch(model, name, -(-count // PARTICLE_THREADS), PARTICLE_THREADS)

    def launch(self, model: DeviceModel, name: str, blocks: int, threads: int) -> None:
        """Start a kernel on so many blocks of threads. Errors: Blowup if one before it has failed."""
        try:
            self.driver.launch(model.kernels()[name], blocks, threads, self.step)
        except DriverError as error:
            raise self._failed(name, error) from None

    def _failed(self, stage: str, error: DriverError) -> Blowup:
        return Blowup(
            f"{self.driver.name} has failed in the stage {stage} ({error.name}): the run can be resumed "
            'from its last checkpoint, here or with numerics.device = "cpu"'
        )

    def found(self, grid: DeviceGrid, stage: str) -> dict[str, Any]:
        """Return what a stage has found, when it is done. Errors: Blowup if it failed."""
        try:
            return grid.results()
        except DriverError as error:
            raise self._failed(stage, error) from None
