"""Smoothed particles as a solver: state, boundary, and the step with its size control."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.diagnostics import MECHANICS, row_of
from neve.gridless.solver import GridlessDiagnostics, GridlessSolver
from neve.scene.schema.scene import Scene, Source
from neve.solver import Arrays, Blowup, StepSummary, joined
from neve.sph.boundary import PLAY
from neve.sph.constants import GROWTH, TRIES
from neve.sph.initial import FIELDS, boundary_of, from_arrays, place_solids, snow_of
from neve.sph.step import STAGES, Attempt, attempt, prepare

if TYPE_CHECKING:
    from neve._core import Sph


class SolveTotals(NamedTuple):
    """Mean iterations of both solves in a step, and their largest residuals [1]; columns of the log."""

    pressure_iterations: float
    pressure_residual: float
    shear_iterations: float
    shear_residual: float


@dataclass(frozen=True, kw_only=True)
class SphDiagnostics(GridlessDiagnostics):
    """Hold the sums over all particles, and `solves`: of the steps since the last advance() began."""

    solves: SolveTotals


class Solves:
    """Count the iterations of the solves of steps that were taken."""

    def __init__(self) -> None:
        self._steps = 0
        self._iterations = [0, 0]
        self._residuals = [0.0, 0.0]

    def add(self, done: Attempt) -> None:
        """Count one step."""
        self._steps += 1
        for k, report in enumerate((done.pressure, done.shear)):
            if report is not None:
                self._iterations[k] += report.iterations
                self._residuals[k] = max(self._residuals[k], report.residual)

    def totals(self) -> SolveTotals:
        """Return means and maxima; zero before the first step."""
        steps = max(self._steps, 1)
        (pressure, shear), (left, left_of_shear) = self._iterations, self._residuals
        return SolveTotals(pressure / steps, left, shear / steps, left_of_shear)


class SphSolver(GridlessSolver):
    """Advance snow as smoothed particles with implicit pressure and shear.

    Attributes:
        state: the particles, a `neve._core.Sph`
    """

    fields = FIELDS
    stages = (*STAGES, "bodies")
    log_columns = (*MECHANICS, *SolveTotals._fields)  # of the steps since the frame before
    state: Sph
    place_solids = staticmethod(place_solids)
    snow_of = staticmethod(snow_of)

    def __init__(self, scene: Scene, saved: Arrays | None = None) -> None:
        """Fill the sources, or go on from `saved`. Errors: SceneError for a source that cannot be used."""
        super().__init__(scene, saved)
        self.placed = place_solids(scene)
        self._boundary = boundary_of(scene, self.placed)
        if saved is None:
            self.state = from_arrays(scene, snow_of(scene, self.placed, range(len(scene.sources))))
        else:
            self.state = from_arrays(scene, saved)
            if self.placed.rigid:
                self.placed.rigid.restore(saved)
        pace = saved["pace"] if saved is not None else (0.0, math.inf)
        self._strain_rate, self._solvable = map(float, pace)
        self._solves = Solves()
        self._cover(0.0)
        self._prepare()
        self._speed = 0.0

    def _cover(self, time: float) -> None:
        """Sample the solids where the snow is now."""
        with self.timer.stage("neighbours"):
            x = np.asarray(self.state.x, dtype=np.float64)
            if not np.isfinite(x).all():
                raise Blowup(self._lost("has no finite place"))
            self.state.set_boundary(*self._boundary.near(x, self.placed.poses(time)))
        self._travelled = 0.0

    def _prepare(self) -> None:
        try:
            prepare(self.state, self.placed.native, self.timer)
        except ValueError as error:
            raise Blowup(self._lost(f"is lost (number {error})")) from None

    def _lost(self, what: str) -> str:
        return f"a particle {what}: lower numerics.cfl or the velocities"

    def begin(self, steps: int, time: float) -> None:
        """Sample the solids anew, and see how fast the snow is. Errors: Blowup."""
        self._set_time(time)
        self._solves = Solves()
        self._cover(time)
        v = np.asarray(self.state.v, dtype=np.float64)
        self._speed = float(np.sqrt(np.max(np.sum(v * v, axis=1), initial=0.0)))
        if not math.isfinite(self._speed):
            raise Blowup(self._lost(f"has no finite velocity after step {steps} (t = {time:.6g} s)"))

    def step(self, steps: int, time: float, remaining: float) -> StepSummary:
        """Take one step: the longest that speed, strain and bodies allow and both solves master.

        Errors: Blowup.
        """
        if self.placed.solids_move:
            with self.timer.stage("bodies"):
                self.placed.place_solids(time)
        numerics = self.scene.numerics
        if self._travelled > PLAY * numerics.spacing:
            self._cover(time)
        self._prepare()
        dt, bound = self._longest()
        dt = remaining / max(1, math.ceil(remaining / dt * (1 - 1e-9)))
        done, dt, rejected = self._tried(dt, steps, time)
        bound = "solve" if rejected else bound
        self._solves.add(done)
        assert done.end is not None
        self._speed, self._strain_rate = done.end.speed, done.end.strain_rate
        self._solvable *= GROWTH if rejected == 0 else 1.0
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
            dt *= 0.5
            self._solvable = dt
        raise Blowup(
            f"after step {steps} (t = {time:.6g} s) no step succeeds, down to {2 * dt:.3g} s: "
            f"{done.refused}; lower numerics.cfl, or check E0 and velocities"
        )

    def _longest(self) -> tuple[float, str]:
        """Return the time step [s] and what bounds it.

        The way of a particle or a solid, `cfl` of the distance of two particles; `strain_max`; the rate at
        which snow can turn a body's velocity, since that is not an unknown of the solves; and after a solve
        that failed GROWTH times the step before.
        """
        numerics = self.scene.numerics
        dt, bound = numerics.dt_max, "dt_max"
        way = numerics.cfl * numerics.spacing
        rates = [
            (self._speed / way, "speed"),
            (self.placed.solid_speed / way, "solid"),
            (self._strain_rate / numerics.strain_max, "strain"),
            (self.state.body_rate(self.placed.native), "body"),
            (1.0 / self._solvable, "solve"),
        ]
        for rate, name in rates:
            if rate * dt > 1.0:
                dt, bound = 1.0 / rate, name
        if numerics.dt != "auto" and float(numerics.dt) <= dt:
            return float(numerics.dt), "fixed"
        return dt, bound

    def end_step(self, steps: int, time: float, dt: float) -> NDArray[np.float64] | None:
        """Move the bodies. Errors: Blowup."""
        self._set_time(time)
        return self._move_bodies(time, dt)

    def diagnostics(self, exchanged: NDArray[np.float64]) -> SphDiagnostics:
        """Add up the state, in double precision in a fixed order."""
        sums = self._sums(self.state.totals(self.placed.native), exchanged)
        return SphDiagnostics(**sums, solves=self._solves.totals())

    def log_values(self, totals: SphDiagnostics) -> Mapping[str, float]:
        """Return the values of the columns of the log, but the excess of energy."""
        solves = totals.solves._asdict()
        return row_of(totals, [name for name in self.log_columns if name not in solves]) | solves

    def save(self) -> dict[str, NDArray[Any]]:
        """Return the state, what the next step is chosen by beside it, and the bodies."""
        return {**super().save(), "pace": np.array([self._strain_rate, self._solvable])}

    def change(self, scene: Scene) -> None:
        """Go on with the same particles in another scene.

        Errors: SceneError for sources that come or go, or snows that part.
        """
        self._go_on_in(scene)
        self._boundary = boundary_of(scene, self.placed)
        self._travelled = math.inf

    def add(self, source: Source, time: float) -> None:
        """Add the snow of `source` at `time` [s], and the source to the scene. Errors: SceneError."""
        scene, placed, fresh, first = self._with_source(source, time)
        there = self.save()
        self.state = from_arrays(scene, joined({name: there[name] for name in fresh}, fresh, first))
        self.scene, self.placed = scene, placed
        self._boundary = boundary_of(scene, placed)
        self._cover(time)
        self._prepare()
