"""The material point method as a solver: model, state and grid, and the step with its size control."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.diagnostics import MECHANICS, Diagnostics, row_of, sums_of
from neve.flow.births import Births
from neve.flow.flow import Flow
from neve.heat.clock import HeatClock
from neve.heat.enthalpy import columns as heat_columns
from neve.mpm.failures import require_finite, require_progress
from neve.mpm.implicit import implicit_of
from neve.mpm.initial import build, make_model
from neve.mpm.model import Model
from neve.mpm.open_snow import OpenState, birth_report
from neve.mpm.rebuild import with_scene, with_source
from neve.mpm.state import (
    BEYOND_NUMBERS,
    FIELDS,
    REST_NUMBERS,
    density,
    fit_modes,
    fit_numbers,
    from_arrays,
    to_arrays,
)
from neve.mpm.state_checks import Densest, inspect, require_whole, too_dense
from neve.mpm.step import STAGES, Stages, on_lattice
from neve.mpm.step_control import try_step
from neve.mpm.time_step import Choice, fitted, largest, limits_of
from neve.scene.schema.scene import Scene, Source
from neve.solver import Arrays, Device, Quantised, Solver, StepSummary

if TYPE_CHECKING:
    from neve._core import Report, State


@dataclass(frozen=True, kw_only=True)
class MpmDiagnostics(Diagnostics):
    """Hold the sums over all particles, and the number of blocks of the grid.

    Of implicit steps since the last advance() began: mean iterations and systems, largest residual,
    share of steps whose contacts had not settled [1].
    """

    blocks: int
    solve_iterations: float = 0.0
    solve_rounds: float = 0.0
    solve_residual: float = 0.0
    solve_unsettled: float = 0.0


class MpmSolver(Solver):
    """Advance snow by the material point method.

    Attributes:
        placed: constants and solids; state: the particles (see neve.mpm.state); grid: of the last step
        births: whose a particle is. flow: snow that comes and goes
        implicit: what solves steps that are not explicit
    """

    fields = FIELDS
    has_heat = True
    has_flow = True
    stages = STAGES
    fixed = (
        *Solver.fixed,
        "devices",
        "deterministic",
        "dx",
        "particles_per_cell",
        "sampling",
        "seed",
        "initial_volume",
    )
    log_columns = (
        *MECHANICS,
        "asleep",  # of the particles, those that no step moves
        "blocks",  # grid blocks of 4x4x4 nodes in use
    )
    state: State
    placed: Model

    def __init__(self, scene: Scene, saved: Arrays | None = None) -> None:
        """Fill the sources, or go on from `saved`. Errors: SceneError for a source that cannot be used."""
        super().__init__(scene, saved)
        if saved is None:
            self.placed, self.state, self.births = build(scene)
        else:
            self.placed = make_model(scene)
            if self.model.rigid:
                self.model.rigid.restore(saved)
            native, modes = self.model.native, np.asarray(saved["modes"])
            polynomial = native.more_modes - native.has_play
            if modes.ndim == 3 and modes.shape[1] in (polynomial, polynomial + 1):
                modes = fit_modes(modes, polynomial, native)
            x, fine = np.asarray(saved["x"]), self.model.is_fine
            rest = fit_numbers(np.asarray(saved["rest"]), REST_NUMBERS, self.model.sleeps, x)
            beyond = fit_numbers(np.asarray(saved["beyond"]), BEYOND_NUMBERS, fine, x)
            self.state = from_arrays(self.model.core, saved, modes=modes, rest=rest, beyond=beyond)
            require_whole(self.model, self.state)
            sources, emitters = len(scene.sources), len(scene.emitters)
            self.births = Births.of_arrays(saved["births"], saved["born"], sources, emitters)
            self._check_births(np.asarray(self.state.id))
        self.heat = HeatClock(saved if scene.heat else None)
        self._let_flow(Flow(scene))
        if saved is not None:
            self.flow.restore(saved)
        self.grid = self.model.core.Grid()
        self.implicit = implicit_of(self.model)
        self._warned = self._warned_of_density = False

    def _check_births(self, ids: NDArray[np.uint32]) -> None:
        """Refuse a saved state without particles, or with one that nobody bore. Errors: ValueError."""
        if not ids.size and not self.scene.is_open:
            raise ValueError("it holds no particle")
        if ids.size and int(ids.max()) >= self.births.count:
            raise ValueError("a particle was born later than any")

    def begin(self, steps: int, time: float) -> None:
        """Derive from the state what a step needs: stress and speeds, at the very first volumes, the grid.

        Errors: Blowup for values in the state that no snow has (see neve.mpm.state_checks).
        """
        if self.scene.is_keyed:
            self.model.set_time(self.scene, time)
        densest = self._inspect()
        self._stages = self._new_stages()
        self.flow.begin()
        if self.implicit:
            self.implicit.begin()
        self._limit_compression()
        self._report = self._stages.refresh()
        require_finite(self.model, self.state, self._report, steps, time, 0.0)
        if steps == 0 and self.scene.numerics.initial_volume == "grid":
            self._stages.measure_volumes()
            self._report = self._stages.refresh()  # the wave speed depends on the volume
            densest = self._inspect()
        if not self._warned_of_density:
            self._warned_of_density = self._warn_of_density(densest, time)
        self._sort_anew(time)

    def _new_stages(self) -> Stages:
        """Return the stages of the step on the particles that there are now."""
        return Stages(self.model, self.state, self.grid, self.timer, self.implicit)

    def _inspect(self) -> Densest:
        """Return the densest particle. Errors: Blowup as `begin`."""
        return inspect(self.model, self.state)

    def _warn_of_density(self, densest: Densest, time: float) -> bool:
        """Log that snow is denser than ice, and return whether it is."""
        sentence = too_dense(self.scene, self.model, self.state, densest, time)
        if sentence:
            logging.getLogger("neve").warning("%s", sentence)
        return bool(sentence)

    def _limit_compression(self) -> None:
        """Tell the model the largest factor on the thresholds of any particle, as far as it has sintered."""
        strength = np.asarray(self.state.strength)
        if self.model.has_heat:
            strength = strength * self.state.thermal[:, 1]
        at_birth = 1.0 if self.scene.emitters else 0.0
        self.model.limit_compression(self._strongest(float(np.max(strength, initial=at_birth))))

    def _strongest(self, found: float) -> float:
        """Return the largest factor on the thresholds, given that of the particles here."""
        return found

    def step(self, steps: int, time: float, remaining: float) -> StepSummary:
        """Take one step, with the dt that the scene allows or less. Errors: Blowup."""
        model = self.model
        if model.solids_move:
            with self.timer.stage("bodies"):
                model.place_solids(time)
        choice = largest(model, self._report)
        require_progress(model, self._report, choice.dt, remaining, steps)
        self._warn_of_long_step(choice, self._report, steps)
        dt = fitted(choice.dt, remaining)
        self._report, dt, rejected = try_step(self._stages, dt, self._report, steps, time)
        if self.implicit:
            self.implicit.accept()
        self._ends = dt >= remaining * (1 - 1e-9)
        return StepSummary(dt, "retry" if rejected else choice.bound, rejected)

    def take_steps(self, steps: int, time: float, remaining: float, most: int) -> Sequence[StepSummary]:
        """Take several steps where the device chooses and judges them itself, as long as no solid moves."""
        if most > 1 and not self.model.solids_move and not self.scene.is_keyed:
            ahead = self._stages.run_ahead(limits_of(self.model), self._report, remaining)
            if ahead is not None:
                taken, self._report = ahead
                return [StepSummary(dt, bound, 0) for dt, bound in taken]
        return [self.step(steps, time, remaining)]

    def end_step(self, steps: int, time: float, dt: float) -> NDArray[np.float64] | None:
        """Check the particles, and let the bodies feel what the snow did to them. Errors: Blowup."""
        require_finite(self.model, self.state, self._report, steps, time, dt)
        exchanged = self._move_bodies(time, dt)
        if self.scene.is_keyed:
            self.model.set_time(self.scene, time)
        if self.scene.is_open:
            self._come_and_go(time, dt)
        if self.scene.heat is not None:
            self._pass_heat(steps, time, dt)
        return exchanged

    def _pass_heat(self, steps: int, time: float, dt: float) -> None:
        """Let heat flow, once it is due, after the step of dt [s] that ends at `time` [s]. Errors: Blowup."""
        core, native, state = self.model.core, self.model.native, self.state
        with self.timer.stage("stress"), on_lattice(self.model):
            found = self.heat.advance(lambda due: core.pass_heat(native, state, due), dt, steps, time)
        if found is None:
            return
        if self.scene.heat and self.scene.heat.sintering:
            self._limit_compression()
        if found.changed:
            self._report = self._stages.refresh()
            require_finite(self.model, state, self._report, steps, time, dt)
        if found.woken:
            self._sort_anew(time)

    def _come_and_go(self, time: float, dt: float) -> None:
        """Let snow come and go in the step of dt [s] that ends at `time` [s]."""
        with self.timer.stage("sort"):
            snow = OpenState(self.scene, self.model, self.state)
            came, went = self.flow.advance(snow, self.births, self._report.speed, time, dt, self._ends)
        if came and self._born is not None:
            self._report.merge(self._born)
        if came or went:
            self.state = snow.state
            self._stages = self._new_stages()
            self._sort_anew(time)

    def _sort_anew(self, time: float) -> None:
        """Sort all particles, those that sleep as well; none does while gravity or snows change."""
        if self.model.sleeps:
            times = [key.t for key in self.scene.world.keyframes]
            times += [key.t for key in self.scene.snow_keyframes]
            changes = max(times, default=0.0) > time
            if changes:
                self.state.rest[...] = 0.0
            self.grid.look_at_all(self._report, not changes)
        self._stages.sort(anew=True)

    def _warn_of_long_step(self, choice: Choice, report: Report, steps: int) -> None:
        """Log, once, that the scene's fixed dt [s] is longer than what is stable, and shortened."""
        numerics = self.scene.numerics
        if self._warned or numerics.dt == "auto" or choice.bound == "fixed":
            return
        self._warned = True
        logging.getLogger("neve").warning(
            "from step %d on numerics.dt = %.3g s is beyond the limit of %.3g s (waves of %.3g m/s) and is "
            'shortened to it: use at most %.3g s, or "auto"',
            steps + 1,
            float(numerics.dt),
            choice.dt,
            report.wave,
            numerics.cfl * numerics.dx / report.fastest,
        )

    def diagnostics(self, exchanged: NDArray[np.float64]) -> MpmDiagnostics:
        """Add up the state, in double precision in a fixed order. Errors: Blowup as `begin`."""
        inspect(self.model, self.state)
        t = self.model.core.totals(self.model.native, self.state)
        return MpmDiagnostics(
            **sums_of(t, exchanged, self.count),
            affine=t.affine,
            asleep=int(np.isinf(self.state.rest).sum()),
            blocks=self._blocks,
            heat=t.heat,
            heat_taken=self.heat.taken,
            water=t.water,
            heat_speed=self.scene.heat.heat_speed if self.scene.heat else 0.0,
            **self.model.totals_of_bodies(),
            **self.flow.books(),
            **(self.implicit.totals()._asdict() if self.implicit else {}),
        )

    def log_values(self, totals: MpmDiagnostics) -> Mapping[str, float]:
        """Return the values of the columns of the log, but the excess of energy."""
        return row_of(totals, self.log_columns)

    def save(self) -> dict[str, NDArray[Any]]:
        """Return the state, whose it is, what comes and goes, the clock of heat, and the rigid bodies."""
        rigid = self.model.rigid
        whose = self.births.arrays()
        heat = self.heat.save() if self.scene.heat else {}
        return {
            **to_arrays(self.state),
            **whose,
            **self.flow.save(),
            **heat,
            **(rigid.save() if rigid else {}),
        }

    @property
    def model(self) -> Model:
        """Constants and solids."""
        return self.placed

    @property
    def _blocks(self) -> int:
        """Number of blocks of the grid in use."""
        return int(self.grid.blocks)

    @property
    def report(self) -> Report:
        """What the last step found in the particles."""
        return self._report

    @property
    def count(self) -> int:
        """Number of particles."""
        return int(self.state.count)

    @property
    def device(self) -> Device | None:
        """The GPU, if the particles are there."""
        found: Device | None = getattr(self.model.core, "device", None)
        return found

    @property
    def bytes(self) -> int:
        """Memory of particles and grid [bytes]."""
        return self.state.bytes + self.grid.bytes

    def columns(self) -> dict[str, Callable[[], Any]]:
        """Return the fields of the state, the stress tau of the last step, the density, the source, who
        sleeps, if somebody may, and with heat temperature and phase.
        """
        state = self.state
        found = super().columns()
        for name in ("beyond", "rest", "enthalpy", "thermal"):  # some scenes have them; infinite ones
            del found[name]
        sleep = {"asleep": lambda: np.isinf(state.rest[:, 0]).astype(np.uint16)} if self.model.sleeps else {}
        own = {
            "tau": lambda: state.tau,
            "density": lambda: density(state),
            "source": lambda: self.births.of(state.id, len(self.scene.sources)),
        }
        heat = heat_columns(lambda: (state.enthalpy[:, 0], state.m)) if self.model.has_heat else {}
        return found | own | sleep | heat

    def quantised(self, value: str) -> Quantised | None:
        """Return positions and the values of a colour from a GPU; None on the processor."""
        found = getattr(self.model.core, "quantised", None)
        return None if found is None else found(self.model.native, self.state, value)

    def take_exchanged(self) -> NDArray[np.float64]:
        """Return what snow and each solid exchanged since the last call, (n, 7)."""
        return self.grid.take_exchanged(len(self.model.solids))

    def change(self, scene: Scene) -> None:
        """Go on with the same snow in another scene. Errors: SceneError (see neve.mpm.rebuild)."""
        self.placed, self.state = with_scene(self.scene, scene, self.model, self.state)
        self._go_on_in(scene)

    def add(self, source: Source, time: float) -> None:
        """Add the snow of `source` at `time` [s], and the source to the scene. Errors: SceneError."""
        scene, self.placed, self.state, self.births = with_source(
            self.scene, source, self.model, self.state, self.births, time
        )
        self._go_on_in(scene)

    def _go_on_in(self, scene: Scene) -> None:
        flow = Flow(scene)
        flow.take_over(self.flow)
        self.scene = scene
        self._let_flow(flow)
        self.grid = self.model.core.Grid()
        self.implicit = implicit_of(self.model)

    def _let_flow(self, flow: Flow) -> None:
        """Let snow come and go by `flow` from now on."""
        self.flow, self._born = flow, birth_report(flow, self.model)
