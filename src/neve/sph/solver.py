"""Smoothed particles as a solver: state, boundary, and the step with its size control."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.build import material_table, require_same_sources, with_one_more
from neve.colliders.solid import Solid
from neve.diagnostics import row_of
from neve.geometry.pose import Pose
from neve.rigid.going_on import going_on
from neve.scene.schema.scene import Scene, Source
from neve.scene.values.curves import keyed
from neve.solver import Arrays, Blowup, Solver, StepSummary, advance_bodies, joined
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


@dataclass(frozen=True)
class SphDiagnostics:
    """Hold the sums over all particles at one instant, in double precision in a fixed order.

    mass [kg], momentum (3,) [kg m/s]; energies [J]: kinetic, elastic, potential (-m g . x); affine is none.
    `work` [J]: of the solids on the snow so far. Of the rigid bodies: bodies_momentum (3,) [kg m/s],
    bodies_kinetic and bodies_potential [J]. `solves`: of the steps since the last advance() began.
    """

    mass: float
    momentum: tuple[float, float, float]
    kinetic: float
    elastic: float
    potential: float
    work: float
    particles: int
    solves: SolveTotals
    affine: float = 0.0
    bodies_momentum: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bodies_kinetic: float = 0.0
    bodies_potential: float = 0.0


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


class SphSolver(Solver):
    """Advance snow as smoothed particles with implicit pressure and shear.

    Attributes:
        state: the particles, a `neve._core.Sph`
    """

    fields = FIELDS
    stages = (*STAGES, "bodies")
    fixed = (*Solver.fixed, "dx", "particles_per_cell", "sampling", "seed")
    log_columns = (
        "mass",  # [kg]
        "momentum_x",  # [kg m/s]
        "momentum_y",
        "momentum_z",
        "kinetic",  # energies [J]
        "elastic",
        "potential",
        "affine",  # none
        "work",  # of the solids on the snow since the start
        "bodies_momentum_x",  # of the bodies that snow moves [kg m/s]
        "bodies_momentum_y",
        "bodies_momentum_z",
        "bodies_kinetic",  # their energies [J]
        "bodies_potential",
        "excess",  # growth of energy since the frame before that nothing accounts for; negative: dissipated
        "particles",
        "pressure_iterations",  # mean of the steps since the frame before
        "pressure_residual",  # largest since then [1]
        "shear_iterations",
        "shear_residual",
    )
    state: Sph

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
        if self.placed.rigid is None:
            return None
        with self.timer.stage("bodies"):
            exchanged = self.take_exchanged()
            advance_bodies(self.placed, dt, exchanged, time)
        return exchanged

    def _set_time(self, time: float) -> None:
        """Give gravity the value that it has at `time` [s]."""
        if self.scene.world.keyframes:
            self.placed.set_gravity(keyed(self.scene.world, "gravity", time))

    def diagnostics(self, exchanged: NDArray[np.float64]) -> SphDiagnostics:
        """Add up the state, in double precision in a fixed order."""
        t = self.state.totals(self.placed.native)
        px, py, pz = t.momentum
        return SphDiagnostics(
            mass=t.mass,
            momentum=(px, py, pz),
            kinetic=t.kinetic,
            elastic=t.elastic,
            potential=t.potential,
            work=float(exchanged[:, 6].sum()),
            particles=self.count,
            solves=self._solves.totals(),
            **self.placed.totals_of_bodies(),
        )

    def log_values(self, totals: SphDiagnostics) -> Mapping[str, float]:
        """Return the values of the columns of the log, but the excess of energy."""
        solves = totals.solves._asdict()
        return row_of(totals, [name for name in self.log_columns if name not in solves]) | solves

    def save(self) -> dict[str, NDArray[Any]]:
        """Return the state, what the next step is chosen by beside it, and the bodies."""
        bodies = self.placed.rigid.save() if self.placed.rigid else {}
        return {**super().save(), "pace": np.array([self._strain_rate, self._solvable]), **bodies}

    @property
    def count(self) -> int:
        """Number of particles."""
        return int(self.state.count)

    @property
    def bytes(self) -> int:
        """Memory of particles, sums and pairs [bytes]."""
        return int(self.state.bytes)

    def columns(self) -> dict[str, Callable[[], Any]]:
        """Return the fields of the state, and the rest density [kg/m3]."""
        state = self.state
        return super().columns() | {"density": lambda: np.asarray(state.m / (state.V0 * state.J_P))}

    @property
    def solids(self) -> Sequence[Solid]:
        """Colliders and rigid bodies."""
        return self.placed.solids

    def poses(self, time: float) -> list[Pose]:
        """Return the pose of each solid at `time` [s]."""
        return self.placed.poses(time)

    def take_exchanged(self) -> NDArray[np.float64]:
        """Return what snow and each solid exchanged since the last call, (n, 7)."""
        return self.state.take_exchanged(len(self.placed.solids))

    def change(self, scene: Scene) -> None:
        """Go on with the same particles in another scene.

        Errors: SceneError for sources that come or go, or snows that part.
        """
        require_same_sources(self.scene, scene)
        self.placed = going_on(self.scene, scene, self.placed, place_solids)
        table = material_table(scene)
        rows = np.array([table.index(scene.snow_of(source)) for source in scene.sources], dtype=np.uint16)
        self.state.material[...] = rows[self.state.source]
        self.scene = scene
        self._boundary = boundary_of(scene, self.placed)
        self._travelled = math.inf

    def add(self, source: Source, time: float) -> None:
        """Add the snow of `source` at `time` [s], and the source to the scene. Errors: SceneError."""
        scene = with_one_more(self.scene, source)
        placed = going_on(self.scene, scene, self.placed, place_solids)
        placed.place_solids(time)
        fresh = snow_of(scene, placed, [len(self.scene.sources)])
        there = self.save()
        first = int(there["id"].max()) + 1 if len(there["id"]) else 0
        self.state = from_arrays(scene, joined({name: there[name] for name in fresh}, fresh, first))
        self.scene, self.placed = scene, placed
        self._boundary = boundary_of(scene, placed)
        self._cover(time)
        self._prepare()
