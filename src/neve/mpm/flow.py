"""Snow that comes and goes while a run goes on: what emitters add to a state and sinks take out of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import material_table
from neve.heat.enthalpy import enthalpy_at
from neve.mpm.births import MOST, Births
from neve.mpm.model import Model
from neve.mpm.state import FIELDS
from neve.sampling.emitters.stream import Comers, Stream, active, directed, stream
from neve.sampling.regions import Region, region
from neve.scene.schema.scene import Scene
from neve.scene.values.curves import keyed
from neve.solver import Blowup
from neve.system.memory import lacking

if TYPE_CHECKING:
    from neve._core import Report, State

COLUMNS = 5
"""Of the books: mass [kg], momentum [kg m/s], energy [J]."""
ROOM = 1.25
"""Particles that there is made room for, over those that there are."""
LEAST_ROOM = 4096


class Flow:
    """Add and take out particles between steps, and keep the books.

    Particles come out of an emitter when the flow has moved by one spacing of particles since the last time,
    and at the end of `Simulation.advance`; each is where it would be had it come out at its own time and
    flown freely. Sinks are emptied when a particle can have moved by a spacing, and at that end.

    Attributes:
        emitted, removed: mass [kg], momentum [kg m/s] and energy [J] of all that came and went, (5,)
    """

    def __init__(self, scene: Scene, model: Model) -> None:
        """Prepare. Errors: SceneError for an emitter or a sink that cannot be used."""
        self._model = model
        self._scene = scene
        numerics = scene.numerics
        self._streams = [stream(scene, i) for i in range(len(scene.emitters))]
        self._sinks: list[Region] = []
        for i, sink in enumerate(scene.sinks):
            self._sinks.append(region(sink, numerics, f"sinks.{i}"))
        table = material_table(scene)
        self._materials = [table.index(scene.snow_of(emitter)) for emitter in scene.emitters]
        self._born = self._birth_report() if self._streams else None
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
        self, state: State, births: Births, report: Report, time: float, dt: float, ends: bool
    ) -> State | None:
        """Let snow come and go in a step of `dt` [s] that ends at `time` [s].

        report: of the step; it takes in the speeds of what came. ends: whether it is the last of an advance.
        Returns the state after that, None if nothing came or went. Errors: Blowup without room for more.
        """
        before = state.count
        came = self._come(state, births, time, dt, ends)
        self._way += report.speed * dt
        went = self._go(came or state, time, ends)
        if came is not None and self._born is not None:
            report.merge(self._born)
        return (came or state) if came is not None or went or state.count != before else None

    # Coming

    def _come(self, state: State, births: Births, time: float, dt: float, ends: bool) -> State | None:
        """Place what has come out; return the state that has it, None if nothing has."""
        changed = None
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
                    changed = self._append(changed or state, births, found, -1 - i)
        return changed

    def _placed_from(self, i: int, time: float) -> dict[str, NDArray[Any]]:
        """Return the particles that have come out of emitter `i` and are not placed, where they are now."""
        source = self._streams[i]
        comers = source.comers(self._placed[i], self._phase[i])
        idle = time - min(time, np.inf if source.emitter.end is None else source.emitter.end)
        ago = idle + (self._phase[i] - comers.phase) / (self._phase[i] - self._placed[i]) * self._waited[i]
        self._placed[i], self._waited[i], self._moved[i] = self._phase[i], 0.0, 0.0
        return self._flown(source, comers, ago[:, None], self._materials[i], time)

    def _flown(
        self, source: Stream, comers: Comers, ago: NDArray[np.float64], material: int, time: float
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

    def _append(self, state: State, births: Births, found: Mapping[str, NDArray[Any]], owner: int) -> State:
        """Return the state with particles added, in more memory if need be. Errors: Blowup."""
        before, count = state.count, len(found["m"])
        if births.count + count > MOST:
            raise Blowup(f"emitters.{-1 - owner} has no number for another particle: {MOST:.2g} were born")
        if before + count > state.capacity:
            wanted = int(ROOM * (before + count)) + LEAST_ROOM
            if problem := lacking(state.bytes * wanted / max(state.capacity, 1)):
                raise Blowup(
                    f"{before} particles and more from emitters.{-1 - owner} need memory, which {problem}: "
                    "raise numerics.dx, lower the rate, end the emitter earlier, or give it a sink"
                )
            state = state.with_room(wanted)
        state.append(count)
        for name, values in found.items():
            getattr(state, name)[before:] = values
        if self._model.has_heat:
            state.enthalpy[before:, 0] = enthalpy_at(self._scene, found["m"])
        state.id[before:] = births.add(owner, count)
        self.emitted += self._sums(state, np.arange(before, before + count))
        return state

    # Going

    def _go(self, state: State, time: float, ends: bool) -> bool:
        """Take out what is in a sink; return whether there was something."""
        if not self._sinks or not (ends or self._way >= self._scene.numerics.spacing):
            return False
        self._way = 0.0
        rows = [
            self._inside(state, space)
            for sink, space in zip(self._scene.sinks, self._sinks, strict=True)
            if sink.start <= time and (sink.end is None or time <= sink.end)
        ]
        gone = np.unique(np.concatenate(rows)) if rows else np.zeros(0, np.uint32)
        if not len(gone):
            return False
        self.removed += self._sums(state, gone)
        if self._model.sleeps:
            self._wake_around(state, np.asarray(state.x[gone], np.float64))
        state.drop(gone.astype(np.uint32))
        return True

    def _wake_around(self, state: State, x: NDArray[np.float64]) -> None:
        """Wake the snow around the places `x` (n, 3) [m]: it loses what it may rest on."""
        far = 8.0 * self._scene.numerics.dx  # two blocks: all that shared a node with it
        state.rest[state.rows_in_box(x.min(axis=0) - far, x.max(axis=0) + far)] = 0.0

    def _inside(self, state: State, space: Region) -> NDArray[np.uint32]:
        low, high = space.bounds()
        rows = state.rows_in_box(np.ascontiguousarray(low), np.ascontiguousarray(high))
        return rows[space.holds(np.asarray(state.x[rows], np.float64))] if len(rows) else rows

    # Sums

    def _sums(self, state: State, rows: NDArray[Any]) -> NDArray[np.float64]:
        """Return mass, momentum and energy of the particles at `rows`, in double in the order of birth."""
        rows = rows[np.argsort(state.id[rows])]
        some = self._model.particles(len(rows))
        for field in FIELDS:
            getattr(some, field.name)[...] = getattr(state, field.name)[rows]
        t = self._model.core.totals(self._model.native, some)
        return np.array([t.mass, *t.momentum, t.kinetic + t.affine + t.elastic + t.potential])

    def _birth_report(self) -> Report:
        """Return what a pass over a particle of each emitter finds at birth."""
        some = self._model.particles(len(self._streams))
        for i, source in enumerate(self._streams):
            times = [0.0, *(key.t for key in source.emitter.keyframes)]
            some.v[i] = max((source.velocity(t) for t in times), key=lambda v: float(np.sum(v * v)))
            some.m[i], some.V0[i] = source.mass, source.volume
            some.material[i] = self._materials[i]
        return self._model.core.refresh(self._model.native, some)
