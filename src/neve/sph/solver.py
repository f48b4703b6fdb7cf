"""Smoothed particles as a solver: state, boundary, and the step with its size control."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.build import has_water, material_table
from neve.diagnostics import MECHANICS, Diagnostics, row_of
from neve.gridless.solver import GridlessSolver
from neve.scene.schema.scene import Scene, Source
from neve.solver import Arrays, Blowup, StepSummary, joined
from neve.sph.boundary import PLAY
from neve.sph.constants import SWING, TRIES, without_counterpart
from neve.sph.initial import FIELDS, boundary_of, from_arrays, place_solids, set_water, snow_of
from neve.sph.pace import Pace
from neve.sph.step import STAGES, Attempt, attempt, prepare

if TYPE_CHECKING:
    from neve._core import Sph


class SolveTotals(NamedTuple):
    """Mean iterations of both solves in a step, and their largest residuals [1]; columns of the log."""

    pressure_iterations: float
    pressure_residual: float
    pressure_largest: float  # of any one particle
    shear_iterations: float
    shear_residual: float


@dataclass(frozen=True, kw_only=True)
class SphDiagnostics(Diagnostics):
    """Hold the sums over all particles, and `solves`: of the steps since the last advance() began."""

    solves: SolveTotals


class Solves:
    """Count the iterations of the solves of steps that were taken."""

    def __init__(self) -> None:
        self._steps = 0
        self._iterations = [0, 0]
        self._residuals = [0.0, 0.0]
        self._largest = 0.0

    def add(self, done: Attempt) -> None:
        """Count one step."""
        self._steps += 1
        self._largest = max(self._largest, done.pressure.largest)
        for k, report in enumerate((done.pressure, done.shear)):
            if report is not None:
                self._iterations[k] += report.iterations
                self._residuals[k] = max(self._residuals[k], report.residual)

    def totals(self) -> SolveTotals:
        """Return means and maxima; zero before the first step."""
        steps = max(self._steps, 1)
        (pressure, shear), (left, left_of_shear) = self._iterations, self._residuals
        return SolveTotals(pressure / steps, left, self._largest, shear / steps, left_of_shear)


class SphSolver(GridlessSolver):
    """Advance snow as smoothed particles with implicit pressure and shear.

    Attributes:
        state: the particles, a `neve._core.Sph`
    """

    fields = FIELDS
    stages = (*STAGES, "bodies")
    log_columns = (*MECHANICS, *SolveTotals._fields)  # of the steps since the frame before
    has_water = True
    when_energy_grows = (
        "its law itself does so where pressed snow yields sideways; elsewhere lower numerics.cfl or "
        "numerics.dt_max"
    )
    state: Sph
    place_solids = staticmethod(place_solids)
    snow_of = staticmethod(snow_of)
    unread_of = staticmethod(without_counterpart)

    def __init__(self, scene: Scene, saved: Arrays | None = None) -> None:
        """Fill the sources, or go on from `saved`. Errors: SceneError for a source that cannot be used."""
        super().__init__(scene, saved)
        self.placed = place_solids(scene)
        self._boundary = boundary_of(scene, self.placed)
        self._time = 0.0 if saved is None else float(saved["time"])
        if saved is None:
            self.state = from_arrays(scene, snow_of(scene, self.placed, range(len(scene.sources))))
        else:
            self.state = from_arrays(scene, saved)
            if self.placed.rigid:
                self.placed.rigid.restore(saved)
            self.placed.place_solids(self._time)
        self._pace = Pace(None if saved is None else saved["pace"])
        self._solves = Solves()
        self._speed = 0.0
        self._cover()
        self._prepare()

    def _cover(self) -> None:
        """Sample the solids where the snow is now."""
        with self.timer.stage("neighbours"):
            x = np.asarray(self.state.x, dtype=np.float64)
            if not np.isfinite(x).all():
                raise Blowup(self._lost("has no finite place"))
            self.state.set_boundary(*self._boundary.near(x, self.placed.poses(self._time)))
        self._travelled = 0.0

    def _prepare(self) -> None:
        try:
            prepare(self.state, self.placed.native, self.timer)
        except ValueError as error:
            raise Blowup(self._lost(f"is lost (number {error})")) from None

    def _lost(self, what: str) -> str:
        return f"a particle {what}: lower numerics.cfl or the velocities"

    def begin(self, steps: int, time: float) -> None:
        """Sample the solids anew, find densities, and see how fast the snow is. Errors: Blowup."""
        self._set_time(time)
        self._solves = Solves()
        self._arrive(time, anew=True)
        v = np.asarray(self.state.v, dtype=np.float64)
        self._speed = float(np.sqrt(np.max(np.sum(v * v, axis=1), initial=0.0)))
        if not math.isfinite(self._speed):
            raise Blowup(self._lost(f"has no finite velocity after step {steps} (t = {time:.6g} s)"))

    def step(self, steps: int, time: float, remaining: float) -> StepSummary:
        """Take one step: the longest that speed, strain, stress and bodies allow and both solves master.

        Errors: Blowup.
        """
        dt, bound = self._longest()
        dt = self._whole(dt, bound, remaining, steps)
        done, dt, rejected = self._tried(dt, steps, time)
        bound = "solve" if rejected else bound
        self._solves.add(done)
        assert done.end is not None
        self._speed, self._pace.strain_rate = done.end.speed, done.end.strain_rate
        self._pace.succeeded(done, bound == "solve" and not rejected)
        self._travelled += dt * (self._speed + self.placed.solid_speed)
        return StepSummary(dt, bound, rejected)

    def _tried(self, dt: float, steps: int, time: float) -> tuple[Attempt, float, int]:
        """Take a step of dt [s], or of half of it, a quarter, ...; return it, its dt, and how many failed.

        Errors: Blowup.
        """
        numerics = self.scene.numerics
        way, strain = numerics.spacing, 4.0 * numerics.strain_max
        for rejected in range(TRIES):
            done = attempt(self.state, self.placed.native, dt, way, strain, self.timer)
            if not done.refused:
                return done, dt, rejected
            self._pace.failed(dt)
            dt *= 0.5
        raise Blowup(
            f"after step {steps} (t = {time:.6g} s) no step succeeds, down to {2 * dt:.3g} s: "
            f"{done.refused}; lower numerics.cfl, or check E0 and velocities"
        )

    def _longest(self) -> tuple[float, str]:
        """Return the time step [s] and what bounds it.

        The way of a particle or a solid, `cfl` of the distance of two particles; `strain_max`; SWING of the
        planes of pressed snow, and the rate at which snow can turn a body's velocity, since neither is an
        unknown of the solves; and what `Pace` has of steps that failed.
        """
        rates = (
            (self._pace.strain_rate / self.scene.numerics.strain_max, "strain"),
            (self.state.stress_rate() / SWING, "stress"),
            (self.state.body_rate(self.placed.native), "body"),
        )
        found = [(1.0 / rate, name) for rate, name in rates if rate > 0.0]
        return self._bounded([*self._ways(self._speed), *found, (self._pace.longest, "solve")])

    def end_step(self, steps: int, time: float, dt: float) -> NDArray[np.float64] | None:
        """Move the bodies, and find the densities of where all is then. Errors: Blowup."""
        self._set_time(time)
        exchanged = self._move_bodies(time, dt)
        self._arrive(time)
        return exchanged

    def _arrive(self, time: float, anew: bool = False) -> None:
        """Put solids where they are at `time` [s], and find what the next step and the log need.

        anew: whether solids are sampled anew, however little the snow has moved. Errors: Blowup.
        """
        self._time = time
        if self.placed.solids_move:
            with self.timer.stage("bodies"):
                self.placed.place_solids(time)
        if anew or self._travelled > PLAY * self.scene.numerics.spacing:
            self._cover()
        self._prepare()

    def diagnostics(self, exchanged: NDArray[np.float64]) -> SphDiagnostics:
        """Add up the state, in double precision in a fixed order."""
        sums = self._sums(self.state.totals(self.placed.native), exchanged)
        return SphDiagnostics(**sums, solves=self._solves.totals())

    def log_values(self, totals: SphDiagnostics) -> Mapping[str, float]:
        """Return the values of the columns of the log, but the excess of energy."""
        solves = totals.solves._asdict()
        return row_of(totals, [name for name in self.log_columns if name not in solves]) | solves

    def columns(self) -> dict[str, Callable[[], Any]]:
        """Return the fields of the state and the density; with water its phase (n,): 0 snow, 1 water [1]."""
        state, found = self.state, super().columns()
        if has_water(self.scene):
            row = material_table(self.scene).index(self.scene.water.material)
            found["phase"] = lambda: (np.asarray(state.material) == row).astype(np.float32)
        return found

    def save(self) -> dict[str, NDArray[Any]]:
        """Return the state, what the next step is chosen by beside it, and the bodies."""
        return {**super().save(), "pace": self._pace.save()}

    def change(self, scene: Scene) -> None:
        """Go on with the same particles in another scene.

        Errors: SceneError for sources that come or go, or snows that part.
        """
        self._go_on_in(scene)
        set_water(scene, self.state)
        self._boundary = boundary_of(scene, self.placed)
        self._arrive(self._time, anew=True)

    def add(self, source: Source, time: float) -> None:
        """Add the snow of `source` at `time` [s], and the source to the scene. Errors: SceneError."""
        scene, placed, fresh, first = self._with_source(source, time)
        there = self.save()
        self.state = from_arrays(scene, joined({name: there[name] for name in fresh}, fresh, first))
        self.scene, self.placed = scene, placed
        self._boundary = boundary_of(scene, placed)
        self._arrive(time, anew=True)
