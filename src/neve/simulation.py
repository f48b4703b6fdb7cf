"""Simulation: a scene in motion."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.backend import backend
from neve.build import with_one_more
from neve.colliders.solid import Solid
from neve.geometry.pose import Pose
from neve.isa import MAX_THREADS
from neve.registry import METHODS
from neve.scene.checks.advice import advice
from neve.scene.errors import SceneWarning
from neve.scene.schema.scene import Scene, Source
from neve.solver import Solver, check_fixed, require_dry
from neve.system.arguments import real, require, whole

if TYPE_CHECKING:
    from neve.run import Output

A_SCENE = 'a neve.Scene, such as neve.load("throw_ball") returns'
A_TIME = "a positive, finite number"
MOST_STEPS = 64
"""So many steps a solver may take at once, if nobody looks at the state between them."""


@dataclass
class Stats:
    """Hold what the last advance() did.

    steps taken, their dt [s] and what bound the smallest one, how many attempts were rejected and tried again
    with a shorter dt, what each solid exchanged with the snow, (n, 7): impulse of the snow on the solid
    [N s], its moment about the origin of its frame [N m s], work of the solid on the snow [J];
    seconds per stage.
    """

    steps: int = 0
    dt_min: float = 0.0
    dt_mean: float = 0.0
    bound: str = ""
    rejected: int = 0
    exchanged: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 7)))
    stage_seconds: dict[str, float] = field(default_factory=dict)

    def add(self, dt: float, bound: str, rejected: int) -> None:
        """Count one step."""
        self.rejected += rejected
        if self.steps == 0 or dt < self.dt_min:
            self.dt_min, self.bound = dt, bound
        self.steps += 1
        self.dt_mean += (dt - self.dt_mean) / self.steps


class Simulation:
    """Simulate the snow of a scene.

    threads: how many to use; all by default. The result does not depend on it, to the bit.
    Warns with SceneWarning of what `neve.scene.checks.advice` finds.
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        require(scene, Scene, "scene", A_SCENE)
        self.scene = scene
        self.threads = checked_threads(threads)
        self.time = 0.0
        """Simulated time [s]."""
        self.steps = 0
        """Number of substeps so far."""
        self.stats = Stats()
        """What the last advance() did."""
        for sentence in advice(scene):
            warnings.warn(sentence, SceneWarning, stacklevel=2)
        self._use_threads()
        self._start(METHODS.get(scene.numerics.method)(scene))
        self.exchanged = np.zeros((len(self.solver.solids), 7))
        """What each solid has exchanged with the snow so far, in the columns of `stats.exchanged`."""

    def _start(self, solver: Solver) -> None:
        self.solver = solver
        """The method that moves the snow (`numerics.method`), with what is its own, such as a grid."""
        self.stats = Stats(stage_seconds=solver.timer.seconds)

    @property
    def state(self) -> Any:
        """The particles as NumPy views: .x .v .id, and what the solver has besides (`solver.fields`)."""
        return self.solver.state

    @property
    def count(self) -> int:
        """Number of particles."""
        return self.solver.count

    @property
    def bytes(self) -> int:
        """Memory of the particles and of what the steps need [bytes]."""
        return self.solver.bytes

    @property
    def radius(self) -> float:
        """Radius of a particle at rest [m], the mean if the solver has one for each."""
        return float(np.mean(self.solver.radius))

    def advance(self, seconds: float, enough: Callable[[], bool] | None = None) -> None:
        """Simulate `seconds` [s] more, in as many substeps as the time step needs.

        Whatever was written into `state` before counts. `enough` is asked after each substep, may read the
        state, and ends the work there if it says so.

        Errors: Blowup if a particle loses its numbers; ValueError if `seconds` is not positive and finite,
        TypeError if it is no number.
        """
        seconds = real(seconds, "seconds", A_TIME)  # a float32 would make the clock one
        if seconds <= 0:
            raise ValueError(f"seconds = {seconds:g} is not {A_TIME}")
        self._use_threads()
        start, done = self.time, 0.0
        self.solver.timer.take()
        self.stats = Stats(stage_seconds=self.solver.timer.seconds)
        self.solver.begin(self.steps, self.time)
        while done < seconds:
            most = MOST_STEPS if enough is None else 1
            for dt, bound, rejected in self.solver.take_steps(self.steps, self.time, seconds - done, most):
                done = seconds if seconds - done <= dt * (1 + 1e-9) else done + dt
                self.time = start + done
                self.steps += 1
                self.stats.add(dt, bound, rejected)
            exchanged = self.solver.end_step(self.steps, self.time, dt)
            if exchanged is not None:
                self._record(exchanged)
            if enough is not None and enough():
                break
        self._record(self.solver.take_exchanged())

    def _record(self, exchanged: NDArray[np.float64]) -> None:
        """Add what the solids exchanged with the snow, (n, 7)."""
        self.stats.exchanged = self.stats.exchanged + exchanged if self.stats.exchanged.size else exchanged
        self.exchanged += exchanged

    def solids(self) -> list[tuple[Solid, Pose]]:
        """Return every solid, the colliders before the bodies, with its pose now."""
        return list(zip(self.solver.solids, self.solver.poses(self.time), strict=True))

    def change(self, scene: Scene) -> None:
        """Go on with the same snow in another scene: snow constants, colliders, gravity, transfer, time step.

        Nothing of the state changes, so a change to the same scene changes nothing.

        Errors: SceneError for what a run cannot change, such as numerics.dx (see `neve.solver.Solver.fixed`).
        """
        require(scene, Scene, "scene", A_SCENE)
        check_fixed(self.solver, scene)
        self.solver.change(scene)
        self._go_on()

    def add(self, source: Source) -> None:
        """Add the snow of `source` now, and the source to the scene.

        Errors: SceneError if the source is too small or too large; pydantic.ValidationError for its snow.
        """
        require(source, Source, "source", "a source, such as one of scene.sources")
        require_dry(self.solver, with_one_more(self.scene, source))
        self.solver.add(source, self.time)
        self._go_on()

    def _go_on(self) -> None:
        """Take over the scene of the solver; exchange totals of removed solids are dropped."""
        totals = np.zeros((len(self.solver.solids), 7))
        kept = min(len(totals), len(self.exchanged))
        totals[:kept] = self.exchanged[:kept]
        self.scene, self.exchanged = self.solver.scene, totals

    def diagnostics(self) -> Any:
        """Return mass, momentum and energies now: with "mpm" a `neve.diagnostics.Diagnostics`."""
        self._use_threads()
        return self.solver.diagnostics(self.exchanged)

    def columns(self) -> dict[str, Callable[[], Any]]:
        """Return what can be drawn of the particles (see `neve.solver.Solver.columns`)."""
        return self.solver.columns()

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything that an exact resume needs: the state, the time and the step count."""
        return {
            **self.solver.save(),
            "exchanged": self.exchanged.copy(),
            "time": np.float64(self.time),  # type: ignore[dict-item]
            "steps": np.int64(self.steps),  # type: ignore[dict-item]
        }

    @classmethod
    def restore(
        cls, scene: Scene, arrays: Mapping[str, NDArray[Any]], threads: int | None = None
    ) -> Simulation:
        """Make the simulation that `arrays()` was taken from; it goes on with the same bits.

        Errors: ValueError, KeyError, IndexError or TypeError for arrays that no simulation of this scene has.
        """
        require(scene, Scene, "scene", A_SCENE)
        require(arrays, Mapping, "arrays", "what Simulation.arrays() returns")
        self = cls.__new__(cls)
        self.scene, self.threads = scene, checked_threads(threads)
        self.time, self.steps = float(arrays["time"]), int(arrays["steps"])
        self._use_threads()
        self._start(METHODS.get(scene.numerics.method)(scene, arrays))
        given = np.asarray(arrays["exchanged"])
        if given.shape != (len(self.solver.solids), 7) or given.dtype.kind != "f":
            raise ValueError(f"exchanged is an array {given.shape} of {given.dtype}")
        self.exchanged = np.array(given, dtype=np.float64)
        if not (
            np.isfinite(self.exchanged).all() and 0.0 <= self.time < math.inf and 0 <= self.steps < 2**62
        ):
            raise ValueError(f"{self.steps} steps at {self.time} s, or what was exchanged, are not possible")
        return self

    def run(
        self,
        out: str | Path,
        frames: int | None = None,
        resume: bool = False,
        force: bool = False,
        quiet: bool = False,
        outputs: Sequence[Output] = (),
    ) -> Simulation:
        """Simulate the whole scene into the run folder `out`: frames, log, checkpoint, preview film.

        outputs: further ones, objects with write(context) and close(context); see neve.run.outputs.context.
        Returns the simulation at the last frame: this one, or with `resume` the one that went on.
        Errors: neve.io.errors.RunError for a folder that cannot be used, one sentence; see neve.run.run.
        """
        from neve.run import run

        return run(self, Path(out), frames=frames, resume=resume, force=force, quiet=quiet, outputs=outputs)

    def _use_threads(self) -> None:
        backend(self.scene.numerics.device).use_threads(self.threads)


def checked_threads(threads: int | None) -> int | None:
    """Return `threads` if the machine can be asked for so many; ValueError or TypeError in one sentence."""
    if threads is None:
        return None
    threads = whole(threads, "threads", f"a whole number from 1 to {MAX_THREADS}")
    if not 1 <= threads <= MAX_THREADS:
        raise ValueError(f"threads = {threads}: from 1 to {MAX_THREADS} on this machine")
    return threads
