"""Simulation: a scene in motion."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.alter import altered, extended
from neve.build import build, make_model
from neve.colliders.solid import Solid
from neve.diagnostics import Diagnostics, diagnose
from neve.geometry.pose import Pose
from neve.isa import MAX_THREADS
from neve.mpm.failures import Blowup, require_finite, require_progress
from neve.mpm.step import STAGES, Stages
from neve.mpm.step_control import try_step
from neve.mpm.time_step import fitted, largest
from neve.rigid.coupled_bodies import LostBody
from neve.scene.checks.advice import advice
from neve.scene.errors import SceneWarning
from neve.scene.schema.scene import Scene, Source
from neve.stage_timer import StageTimer
from neve.state import from_arrays, to_arrays

if TYPE_CHECKING:
    from neve._core import Report, State
    from neve.run import Output


@dataclass
class Stats:
    """Hold what the last advance() did.

    steps taken, their dt [s] and what bound the smallest one, how many attempts were rejected and tried again
    with a shorter dt, what each collider exchanged with the snow, (n, 7): impulse of the snow on the collider
    [N s], its moment about the collider's centre [N m s], work of the collider on the snow [J];
    seconds per stage.
    """

    steps: int = 0
    dt_min: float = 0.0
    dt_mean: float = 0.0
    bound: str = ""
    rejected: int = 0
    exchanged: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 7)))
    stage_seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(STAGES, 0.0))

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
        self.scene = scene
        self.threads = checked_threads(threads)
        self.time = 0.0
        """Simulated time [s]."""
        self.steps = 0
        """Number of substeps so far."""
        self.stats = Stats()
        """What the last advance() did."""
        self._warned = False
        for sentence in advice(scene):
            warnings.warn(sentence, SceneWarning, stacklevel=2)
        self._use_threads()
        self.model, self._state = build(scene)
        self._grid = self.model.core.Grid()
        self.exchanged = np.zeros((len(self.model.solids), 7))
        """What each solid has exchanged with the snow so far, in the columns of `stats.exchanged`."""

    @property
    def state(self) -> State:
        """The particles: .x .v .J_P .F_E .m and more, as NumPy views (see neve.state)."""
        return self._state

    @property
    def blocks(self) -> int:
        """Grid blocks of 4x4x4 nodes in use."""
        return self._grid.blocks

    @property
    def bytes(self) -> int:
        """Memory of particles and grid [bytes]."""
        return self._state.bytes + self._grid.bytes

    def advance(self, seconds: float, enough: Callable[[], bool] | None = None) -> None:
        """Simulate `seconds` [s] more, in as many substeps as the time step needs.

        Whatever was written into `state` before counts. `enough` is asked after each substep, may read the
        state, and ends the work there if it says so.

        Errors: Blowup if a particle loses its numbers; ValueError if `seconds` is not positive and finite.
        """
        if not (np.isfinite(seconds) and seconds > 0):
            raise ValueError(f"seconds = {seconds}: a positive, finite number")
        self._use_threads()
        model, state = self.model, self._state
        start, done = self.time, 0.0
        self.stats = Stats()
        self._timer = StageTimer(STAGES)
        self.stats.stage_seconds = self._timer.seconds
        stages = Stages(model, state, self._grid, self._timer)
        report = self._begin(stages)
        while done < seconds:
            if model.solids_move:
                self._place_solids(start + done)
            choice = largest(model, report)
            require_progress(model, report, choice.dt, seconds, self.steps)
            self._warn_of_long_step(choice.dt, report)
            dt = fitted(choice.dt, seconds - done)
            report, dt, rejected = try_step(stages, dt, report, self.steps, self.time)
            done = seconds if seconds - done <= dt * (1 + 1e-9) else done + dt
            self.time = start + done
            self.steps += 1
            self.stats.add(dt, "retry" if rejected else choice.bound, rejected)
            require_finite(model, state, report, self.steps, self.time, dt)
            self._move_bodies(dt)
            if enough is not None and enough():
                break
        self._take_exchanged()

    def _place_solids(self, time: float) -> None:
        with self._timer.stage("bodies"):
            self.model.place_solids(time)

    def _move_bodies(self, dt: float) -> None:
        """Let the rigid bodies feel what the snow did to them in the step of dt [s] that ends now."""
        if self.model.rigid is None:
            return
        with self._timer.stage("bodies"):
            exchanged = self._take_exchanged()
            try:
                self.model.rigid.advance(dt, exchanged[len(self.model.colliders) :], self.time - dt)
            except LostBody as lost:
                raise Blowup(str(lost)) from None

    def _take_exchanged(self) -> NDArray[np.float64]:
        """Return what the solids exchanged with the snow since the last call, and book it."""
        exchanged = self._grid.take_exchanged(len(self.model.solids))
        self.stats.exchanged = self.stats.exchanged + exchanged if self.stats.exchanged.size else exchanged
        self.exchanged += exchanged
        return exchanged

    def _warn_of_long_step(self, dt: float, report: Report) -> None:
        """Log, once, that the scene's fixed dt [s] has become longer than waves and speeds allow."""
        numerics = self.scene.numerics
        if self._warned or numerics.dt == "auto" or dt * report.fastest <= numerics.dx:
            return
        self._warned = True
        logging.getLogger("neve").warning(
            "from step %d on numerics.dt = %.3g s is beyond the limit of %.3g s (waves of %.3g m/s): "
            'use at most %.3g s, or "auto"',
            self.steps + 1,
            dt,
            numerics.dx / report.fastest,
            report.wave,
            numerics.cfl * numerics.dx / report.fastest,
        )

    def _begin(self, stages: Stages) -> Report:
        """Derive from the state what a step needs: stress and speeds, at the very first volumes, the grid."""
        model, state = self.model, self._state
        model.limit_press(float(np.max(state.strength, initial=0.0)))
        report = stages.refresh()
        require_finite(model, state, report, self.steps, self.time, 0.0)
        if self.steps == 0 and self.scene.numerics.initial_volume == "grid":
            stages.measure_volumes()
            report = stages.refresh()  # the wave speed depends on the volume
        stages.sort(anew=True)
        return report

    def solids(self) -> list[tuple[Solid, Pose]]:
        """Return every solid, the colliders before the bodies, with its pose now."""
        return list(zip(self.model.solids, self.model.poses(self.time), strict=True))

    def change(self, scene: Scene) -> None:
        """Go on with the same snow in another scene: snow constants, colliders, gravity, transfer, time step.

        Nothing of the state changes, so a change to the same scene changes nothing.

        Errors: SceneError for what a run cannot change, such as numerics.dx (see neve.alter).
        """
        self.model, self._state = altered(self.scene, scene, self.model, self._state)
        self._go_on_in(scene)

    def add(self, source: Source) -> None:
        """Add the snow of `source` now, and the source to the scene.

        Errors: SceneError if the source is too small or too large; pydantic.ValidationError for its snow.
        """
        scene, self.model, self._state = extended(self.scene, source, self.model, self._state, self.time)
        self._go_on_in(scene)

    def _go_on_in(self, scene: Scene) -> None:
        """Take `scene` over; the books of solids that are gone are closed."""
        books = np.zeros((len(self.model.solids), 7))
        kept = min(len(books), len(self.exchanged))
        books[:kept] = self.exchanged[:kept]
        self.scene, self.exchanged = scene, books
        self._grid = self.model.core.Grid()

    def diagnostics(self) -> Diagnostics:
        """Return mass, momentum and energies now."""
        self._use_threads()
        return diagnose(self.model, self._state, self._grid, self.exchanged)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything that an exact resume needs: the state, the time and the step count."""
        rigid = self.model.rigid
        return {
            **to_arrays(self._state),
            **(rigid.save() if rigid else {}),
            "exchanged": self.exchanged.copy(),
            "time": np.float64(self.time),  # type: ignore[dict-item]
            "steps": np.int64(self.steps),  # type: ignore[dict-item]
        }

    @classmethod
    def restore(
        cls, scene: Scene, arrays: Mapping[str, NDArray[Any]], threads: int | None = None
    ) -> Simulation:
        """Make the simulation that `arrays()` was taken from; it goes on with the same bits."""
        self = cls.__new__(cls)
        self.scene, self.threads, self.stats = scene, checked_threads(threads), Stats()
        self._warned = False
        self.time, self.steps = float(arrays["time"]), int(arrays["steps"])
        self._use_threads()
        self.model = make_model(scene)
        if self.model.rigid:
            self.model.rigid.restore(arrays)
        self._state = from_arrays(self.model.core, arrays)
        self._grid = self.model.core.Grid()
        self.exchanged = np.array(arrays["exchanged"], dtype=np.float64)
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
        _core.set_threads(self.threads or _default_threads)


_default_threads = _core.threads()


def checked_threads(threads: int | None) -> int | None:
    """Return `threads` if the machine can be asked for so many; ValueError in one sentence otherwise."""
    if threads is not None and not 1 <= threads <= MAX_THREADS:
        raise ValueError(f"threads = {threads}: from 1 to {MAX_THREADS} on this machine")
    return threads
