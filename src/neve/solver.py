"""The solver seam: what a method of simulation gives, so that it is run, filmed, viewed, resumed and logged.

A solver is a subclass of `Solver` with a word in `neve.registry.METHODS`, which `numerics.method` chooses.
Nothing else in Neve names a method: `Simulation` holds the scene, the clock and a solver.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.build import PlacedSolids
from neve.colliders.solid import Solid
from neve.geometry.pose import Pose
from neve.registry import METHODS
from neve.rigid.coupled_bodies import LostBody
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene, Snow, Source
from neve.scene.values.allowed import words
from neve.stage_timer import StageTimer

Arrays = Mapping[str, NDArray[Any]]


class Blowup(RuntimeError):
    """Raised when a run cannot go on: which particle, where, when, and what to change, in one sentence."""


class Field(NamedTuple):
    """An array of the state, a row for each particle, which is what a checkpoint holds.

    Attributes:
        name: attribute of `Solver.state`
        shape: of a row: () for a number, (3,) for a vector; "k" stands for a length that the scene chooses
        unit: SI; "1" for a pure number, "" for names
        dtype: "real" for the precision of the run, or the name of a NumPy type
        meaning: one line
    """

    name: str
    shape: tuple[int | str, ...]
    unit: str
    dtype: str
    meaning: str


class StepSummary(NamedTuple):
    """A step that was taken: its dt [s], what bound it, and how many attempts were rejected before."""

    dt: float
    bound: str
    rejected: int


class Device(NamedTuple):
    """A device beside the processor: its name, and how much of its memory is free [bytes]."""

    name: str
    free: int


class Quantised(NamedTuple):
    """Positions and the values of a colour in 16 bits each: x, y, z and the value are low + step q.

    Attributes:
        id: of each particle, (n,); q: (n, 4); low, step: (4,), in m and the unit of the value.
        A particle without finite numbers has q = (65535, 65535, 65535, ...).
    """

    id: NDArray[Any]
    q: NDArray[np.uint16]
    low: NDArray[np.float64]
    step: NDArray[np.float64]


class Solver(ABC):
    """Advance the snow of a scene.

    `Solver(scene)` fills the scene's sources; `Solver(scene, saved)` goes on from what `save` returned, with
    the same bits. Whatever is not abstract here has an answer for a method without it: no solids, no stages
    to time, no change while a run goes on.
    """

    fields: ClassVar[tuple[Field, ...]]
    """What the state consists of."""
    stages: ClassVar[tuple[str, ...]] = ()
    """Names of the stages that `timer` measures; each has a column `seconds_NAME` in the log."""
    fixed: ClassVar[tuple[str, ...]] = ("method", "device", "precision")
    """Keys of [numerics] that say how a state was made, or how its arrays look: no run can change them."""
    has_heat: ClassVar[bool] = False
    """Whether the method knows the heat of a scene."""
    has_flow: ClassVar[bool] = False
    """Whether snow may come and go: whether the method knows emitters and sinks."""
    has_water: ClassVar[bool] = False
    """Whether the method knows water of sources of its own."""
    unread: ClassVar[tuple[str, ...]] = ()
    """Keys of [numerics] that the method does not read."""
    log_columns: ClassVar[tuple[str, ...]] = ()
    """Columns of the log that `log_values` fills, between those of the clock and the seconds. "excess" is
    filled by the run, from `diagnostics` with the members of `neve.diagnostics.Balance`."""

    when_energy_grows: ClassVar[str] = (
        "lower numerics.cfl or numerics.strain_max, or check xi, theta_c and theta_s"
    )
    """What a run advises where the energy of the snow grows without work."""

    state: Any
    """The particles, with a NumPy array for each of `fields`; x, v and id are always there."""
    placed: PlacedSolids | None = None
    """The scene's solids where they are now, in the core; None for a method that knows none."""

    @abstractmethod
    def __init__(self, scene: Scene, saved: Arrays | None = None) -> None:
        _require_able(self, scene)
        require_dry(self, scene)
        self.scene = scene
        self.timer = StageTimer(self.stages)

    @staticmethod
    def unread_of(snow: Snow) -> tuple[str, ...]:
        """Return the constants of `snow` that the method does not read."""
        return ()

    # Time

    def begin(self, steps: int, time: float) -> None:
        """Prepare for steps after the state may have been written to; `steps` are done at `time` [s]."""
        return

    @abstractmethod
    def step(self, steps: int, time: float, remaining: float) -> StepSummary:
        """Take one step from `time` [s], of at most `remaining` [s]; `steps` were taken before.

        Errors: Blowup if no step is possible.
        """

    def take_steps(self, steps: int, time: float, remaining: float, most: int) -> Sequence[StepSummary]:
        """Take steps as `step` does, at least one and at most `most`, of at most `remaining` [s] in all.

        For a method that can do so with less effort than one by one; after the last follows `end_step`.
        """
        return [self.step(steps, time, remaining)]

    def end_step(self, steps: int, time: float, dt: float) -> NDArray[np.float64] | None:
        """Finish the step of dt [s] that ends at `time` [s], `steps` since the start: check it, move bodies.

        Returns what `take_exchanged` would, if bodies needed it. Errors: Blowup.
        """
        return None

    # Sums and files

    def diagnostics(self, exchanged: NDArray[np.float64]) -> Any:
        """Return sums over the state; `exchanged` is that of the Simulation."""
        return {}

    def log_values(self, totals: Any) -> Mapping[str, float]:
        """Return the values of `log_columns`, by name, from what `diagnostics` returned."""
        return dict(totals)

    def save(self) -> dict[str, NDArray[Any]]:
        """Return copies of all arrays that an exact resume needs."""
        return {field.name: np.array(getattr(self.state, field.name)) for field in self.fields}

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.state.x)

    @property
    def device(self) -> Device | None:
        """What computes the steps, if it is not the processor: then `bytes` are in its memory."""
        return None

    @property
    def bytes(self) -> int:
        """Memory of the state and of what the steps need besides [bytes]."""
        return sum(np.asarray(getattr(self.state, field.name)).nbytes for field in self.fields)

    # What can be drawn

    def columns(self) -> dict[str, Callable[[], Any]]:
        """Return what film and viewer may draw of the particles, made when it is asked for.

        "x" [m] (n, 3), "v" [m/s] (n, 3) and "id" (n,) are always there. Colour modes and frames take more
        where it is: "J_P" [1] (n,), volume after plastic flow over that at birth; "material" (n,), row of the
        material table; "density" [kg/m3] (n,); "tau" [Pa] (n, 6), "F_E" [1] (n, 3, 3);
        "source" (n,), index of the source that a particle came from.
        """
        return {field.name: _getter(self.state, field.name) for field in self.fields}

    def quantised(self, value: str) -> Quantised | None:
        """Return positions, and the values of a colour mode, where that saves a copy of `columns`.

        value: "speed", "J_P", "density", "stress" or "material"; "" for positions alone. None: only `columns`
        have them.
        """
        return None

    @property
    def radius(self) -> float | NDArray[Any]:
        """Radius of the particles [m], one or (n,): half the distance of two that touch, at rest.

        By default what dx and particles_per_cell say. Film and viewer draw all alike, by the mean.
        """
        return self.scene.numerics.spacing / 2

    # Solids

    @property
    def solids(self) -> Sequence[Solid]:
        """Colliders and rigid bodies that the snow meets."""
        return self.placed.solids if self.placed else ()

    def poses(self, time: float) -> list[Pose]:
        """Return where each of `solids` is at `time` [s]."""
        return self.placed.poses(time) if self.placed else []

    def take_exchanged(self) -> NDArray[np.float64]:
        """Return what snow and each of `solids` exchanged since the last call, (len(solids), 7).

        Impulse of the snow on the solid [N s], its moment about the solid's centre [N m s], work of the solid
        on the snow [J].
        """
        return np.zeros((len(self.solids), 7))

    def _move_bodies(self, time: float, dt: float) -> NDArray[np.float64] | None:
        """Let bodies feel what the snow did to them in the step of dt [s] that ends at `time` [s].

        Returns what `take_exchanged` did, if there are bodies. Errors: Blowup for a body that is lost.
        """
        if self.placed is None or self.placed.rigid is None:
            return None
        with self.timer.stage("bodies"):
            exchanged = self.take_exchanged()
            try:
                self.placed.rigid.advance(dt, exchanged[len(self.placed.colliders) :], time - dt)
            except LostBody as lost:
                raise Blowup(str(lost)) from None
        return exchanged

    # Change

    def change(self, scene: Scene) -> None:
        """Go on with the same snow in another scene. Errors: SceneError for what cannot change."""
        raise self._cannot("change its scene")

    def add(self, source: Source, time: float) -> None:
        """Add the snow of `source` at `time` [s], and the source to `scene`. Errors: SceneError."""
        raise self._cannot("add snow")

    def _cannot(self, what: str) -> SceneError:
        return SceneError(f'numerics.method = "{self.scene.numerics.method}" cannot {what} in a run')


def fill_columns(state: Any, fields: Sequence[Field], arrays: Arrays) -> None:
    """Copy `arrays` into the columns of `state`.

    Errors: ValueError for an array of another shape, or of numbers of another kind.
    """
    for field in fields:
        column, given = getattr(state, field.name), np.asarray(arrays[field.name])
        if given.shape != column.shape or given.dtype != column.dtype:
            raise ValueError(
                f"{field.name} is an array {given.shape} of {given.dtype}: "
                f"these particles need {column.shape} of {column.dtype}"
            )
        column[...] = given


def joined(there: Arrays, fresh: Arrays, first: int) -> dict[str, NDArray[Any]]:
    """Return the columns of the particles that are there, and of fresh ones after them.

    The fresh ones are named (id) on from `first`.
    """
    ids = np.arange(first, first + len(fresh["id"]), dtype=there["id"].dtype)
    named = {**fresh, "id": ids}
    return {name: np.concatenate([there[name], named[name]]) for name in named}


def _getter(state: Any, name: str) -> Callable[[], Any]:
    return lambda: getattr(state, name)


def _require_able(solver: Solver, scene: Scene) -> None:
    """Refuse a scene with heat, emitters or sinks for a method that knows none. Errors: SceneError."""
    needs = (
        ("heat", scene.heat is not None, "has_heat", "knows no heat", ", or leave [heat] out"),
        ("emitters", bool(scene.emitters), "has_flow", "adds and removes no snow", ""),
        ("sinks", bool(scene.sinks), "has_flow", "adds and removes no snow", ""),
    )
    method = scene.numerics.method
    for part, there, ability, lacks, otherwise in needs:
        if there and not getattr(solver, ability):
            able = [name for name in METHODS.names() if getattr(METHODS.get(name), ability)]
            raise SceneError(f'{part}: numerics.method = "{method}" {lacks}; use {words(able)}{otherwise}')


def require_dry(solver: Solver, scene: Scene) -> None:
    """Refuse a scene with sources of water for a method that knows none. Errors: SceneError."""
    if solver.has_water:
        return
    able = [name for name in METHODS.names() if METHODS.get(name).has_water]
    method = scene.numerics.method
    for i, source in enumerate(scene.sources):
        if source.is_water:
            raise SceneError(
                f'sources.{i}.phase = "water": numerics.method = "{method}" knows snow alone; '
                f"use {words(able)}"
            )


def check_fixed(solver: Solver, new_scene: Scene) -> None:
    """Refuse a new scene for `solver` that differs in one of its `fixed` keys. Errors: SceneError."""
    for key in solver.fixed:
        if getattr(new_scene.numerics, key) != getattr(solver.scene.numerics, key):
            raise SceneError(f"numerics.{key} cannot change while a run goes on; start it anew")
    if (solver.scene.heat is None) != (new_scene.heat is None):
        raise SceneError("heat cannot come or go while a run goes on; start it anew")
