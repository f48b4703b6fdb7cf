"""When snow comes and goes: what emitters add between steps and sinks take out, and the books of both."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.build import material_table
from neve.flow.births import MOST, Births
from neve.sampling.emitters.stream import Comers, Stream, active, directed, stream
from neve.sampling.regions import Region, region
from neve.scene.schema.scene import Scene
from neve.scene.values.curves import keyed
from neve.solver import Blowup
from neve.system.memory import lacking

COLUMNS = 5
"""Of the books: mass [kg], momentum [kg m/s], energy [J]."""

Array = NDArray[np.float64]


class Newborn(NamedTuple):
    """Snow as it leaves an emitter: its fastest velocity [m/s] (3,), mass [kg] and volume [m3] of a layer,
    `particles` in one, and the row of its snow in the material table."""

    v: Array
    mass: float
    volume: float
    particles: int
    material: int


class OpenSnow(ABC):
    """The particles of a method as `Flow` adds to them and takes out of them.

    Rows are numbers of particles in the order that they have now; `append` and `drop` may give them others.
    """

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of particles."""

    @abstractmethod
    def bytes_with(self, count: int) -> float:
        """Return how much memory it would take to hold `count` particles in place of those there are [bytes];
        0 if there is room."""

    @abstractmethod
    def append(self, columns: Mapping[str, NDArray[Any]], emitter: int, ids: NDArray[np.uint32]) -> None:
        """Add n particles of an emitter after the others.

        columns: x (n, 3) [m], v (n, 3) [m/s], m (n,) [kg], V0 (n,) [m3], material (n,). ids: birth numbers.
        """

    @abstractmethod
    def positions(self, low: Array, high: Array) -> tuple[NDArray[np.uint32], Array]:
        """Return rows (n,), those of all particles from `low` to `high` (3,) [m] among them, and where these
        are (n, 3) [m].
        """

    @abstractmethod
    def drop(self, rows: NDArray[np.uint32]) -> None:
        """Take out the particles at `rows`, which rise; wake what may rest on them."""

    @abstractmethod
    def sums(self, rows: NDArray[Any]) -> Array:
        """Return mass, momentum and energy of the particles at `rows` (5,), in double in the order of birth:
        what all lose when these are dropped.
        """


class Flow:
    """Add and take out particles between steps, and keep the books.

    Particles come out of an emitter when the flow has moved by one spacing of particles since the last time,
    and at the end of `Simulation.advance`; each is where it would be had it come out at its own time and
    flown freely. Sinks are emptied when a particle can have moved by a spacing, when one opens or closes, and
    at that end.

    Attributes:
        emitted, removed: mass [kg], momentum [kg m/s] and energy [J] of all that came and went, (5,)
    """

    def __init__(self, scene: Scene) -> None:
        """Prepare. Errors: SceneError for an emitter or a sink that cannot be used."""
        self._scene = scene
        numerics = scene.numerics
        self._streams = [stream(scene, i) for i in range(len(scene.emitters))]
        self._sinks: list[Region] = []
        for i, sink in enumerate(scene.sinks):
            self._sinks.append(region(sink, numerics, f"sinks.{i}"))
        table = material_table(scene)
        self._materials = [table.index(scene.snow_of(emitter)) for emitter in scene.emitters]
        emitters = len(scene.emitters)
        self._phase = np.zeros(emitters)  # layers that have come out, and those that are to be placed
        self._placed = np.zeros(emitters)  # layers whose particles are placed
        self._waited = np.zeros(emitters)  # time at work since then [s]
        self._moved = np.zeros(emitters)  # way of the flow since then [m]
        self._way = 0.0  # of the fastest particle since sinks were emptied [m]
        self.emitted, self.removed = np.zeros(COLUMNS), np.zeros(COLUMNS)

    def save(self) -> dict[str, NDArray[Any]]:
        """Return what an exact resume needs; nothing for a scene in which snow neither comes nor goes."""
        if not self._scene.is_open:
            return {}
        flow = np.stack([self._phase, self._placed, self._waited, self._moved])
        return {"flow": flow, "flow_books": np.stack([self.emitted, self.removed])}

    def restore(self, saved: Mapping[str, NDArray[Any]]) -> None:
        """Go on from what `save` returned. Errors: ValueError for what it never returns."""
        if not self._scene.is_open:
            return
        flow, books = np.array(saved["flow"]), np.array(saved["flow_books"])
        right = flow.shape == (4, len(self._streams)) and books.shape == (2, COLUMNS)
        if not (right and flow.dtype == books.dtype == np.float64 and np.isfinite(flow).all()):
            raise ValueError(f"flow is an array {flow.shape} of {flow.dtype}, not of these emitters")
        self._phase, self._placed, self._waited, self._moved = flow
        self.emitted, self.removed = books

    def books(self) -> dict[str, Any]:
        """Return what came and went so far, by the names of `neve.diagnostics.Diagnostics`."""
        found: dict[str, Any] = {}
        for word, sums in (("emitted", self.emitted), ("removed", self.removed)):
            mass, *momentum, energy = (float(value) for value in sums)
            found |= {f"{word}_mass": mass, f"{word}_momentum": tuple(momentum), f"{word}_energy": energy}
        return found

    def take_over(self, other: Flow) -> None:
        """Go on from the flow of a scene whose emitters are the first of this one's."""
        kept = len(other._phase)
        for name in ("_phase", "_placed", "_waited", "_moved"):
            getattr(self, name)[:kept] = getattr(other, name)
        self.emitted, self.removed, self._way = other.emitted, other.removed, other._way

    def begin(self) -> None:
        """Note that `Simulation.advance` begins."""
        self._way = 0.0

    def advance(
        self, snow: OpenSnow, births: Births, speed: float, time: float, dt: float, ends: bool
    ) -> tuple[bool, bool]:
        """Let snow come and go in a step of `dt` [s] that ends at `time` [s].

        speed: of the fastest particle [m/s]. ends: whether it is the last of an advance.
        Returns whether some came, and whether some went. Errors: Blowup without room for more.
        """
        came = self._come(snow, births, time, dt, ends)
        self._way += speed * dt
        return came, self._go(snow, time - dt, time, ends)

    def at_birth(self) -> list[Newborn]:
        """Return what snow is like as it leaves each emitter."""
        found = []
        for source, material in zip(self._streams, self._materials, strict=True):
            times = [0.0, *(key.t for key in source.emitter.keyframes)]
            fastest = max((source.velocity(t) for t in times), key=lambda v: float(np.sum(v * v)))
            found.append(Newborn(fastest, source.mass, source.volume, len(source.middles), material))
        return found

    # Coming

    def _come(self, snow: OpenSnow, births: Births, time: float, dt: float, ends: bool) -> bool:
        """Place what has come out; return whether something has."""
        came = False
        for i, source in enumerate(self._streams):
            first, last = active(source.emitter, time - dt, time)
            if last > first:
                self._phase[i] += source.layers(first, last)
                self._waited[i] += last - first
                v = source.velocity(time)
                self._moved[i] += float(np.sqrt(np.sum(v * v))) * (last - first)
            due = self._moved[i] >= source.spacing * (1 - 1e-9)
            if self._phase[i] > self._placed[i] and (due or ends or last - first < dt * (1 - 1e-9)):
                found = self._placed_from(i, time)
                if len(found["m"]):
                    self._append(snow, births, found, i)
                    came = True
        return came

    def _placed_from(self, i: int, time: float) -> dict[str, NDArray[Any]]:
        """Return the particles that have come out of emitter `i` and are not placed, where they are now."""
        source = self._streams[i]
        comers = source.comers(self._placed[i], self._phase[i])
        idle = time - min(time, np.inf if source.emitter.end is None else source.emitter.end)
        ago = idle + (self._phase[i] - comers.phase) / (self._phase[i] - self._placed[i]) * self._waited[i]
        self._placed[i], self._waited[i], self._moved[i] = self._phase[i], 0.0, 0.0
        return self._flown(source, comers, ago[:, None], self._materials[i], time)

    def _flown(
        self, source: Stream, comers: Comers, ago: Array, material: int, time: float
    ) -> dict[str, NDArray[Any]]:
        """Return particles that came out so long `ago` [s] (n, 1) and have fallen freely until `time` [s]."""
        g = keyed(self._scene.world, "gravity", time)
        v = directed(source.velocity(time), source.emitter.spread, comers.aim)
        count = len(comers.phase)
        return {
            "x": comers.place + ago * v + 0.5 * ago * ago * g,
            "v": v + ago * g,
            "m": np.full(count, source.mass / len(source.middles)),
            "V0": np.full(count, source.volume / len(source.middles)),
            "material": np.full(count, material, np.uint16),
        }

    def _append(
        self, snow: OpenSnow, births: Births, found: Mapping[str, NDArray[Any]], emitter: int
    ) -> None:
        """Add particles to the others. Errors: Blowup without memory or numbers for more."""
        before, count = snow.count, len(found["m"])
        if births.count + count > MOST:
            raise Blowup(f"emitters.{emitter} has no number for another particle: {MOST:.2g} were born")
        if (wanted := snow.bytes_with(before + count)) and (problem := lacking(wanted)):
            raise Blowup(
                f"{before} particles and more from emitters.{emitter} need memory, which {problem}: "
                "raise numerics.dx, lower the rate, end the emitter earlier, or give it a sink"
            )
        snow.append(found, emitter, births.add(-1 - emitter, count))
        self.emitted += snow.sums(np.arange(before, before + count))

    # Going

    def _go(self, snow: OpenSnow, begin: float, time: float, ends: bool) -> bool:
        """Take out what is in a sink at the end of a step from `begin` to `time` [s]; return whether it was.

        A sink that opens or closes in the step is looked at as well: snow in it may be slow.
        """
        turns = any(
            begin < sink.start <= time or (sink.end is not None and begin <= sink.end < time)
            for sink in self._scene.sinks
        )
        if not self._sinks or not (ends or turns or self._way >= self._scene.numerics.spacing):
            return False
        self._way = 0.0
        rows = [
            _inside(snow, space)
            for sink, space in zip(self._scene.sinks, self._sinks, strict=True)
            if sink.start <= time and (sink.end is None or begin <= sink.end)
        ]
        gone = np.unique(np.concatenate(rows)) if rows else np.zeros(0, np.uint32)
        if not len(gone):
            return False
        self.removed += snow.sums(gone)
        snow.drop(gone.astype(np.uint32))
        return True


def _inside(snow: OpenSnow, space: Region) -> NDArray[np.uint32]:
    """Return the rows of the particles in `space`."""
    rows, x = snow.positions(*map(np.ascontiguousarray, space.bounds()))
    return rows[space.holds(x)] if len(rows) else rows
