"""The particles of the material point method as snow that comes and goes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.flow.flow import Flow, OpenSnow
from neve.heat.enthalpy import enthalpy_at
from neve.mpm.model import Model
from neve.mpm.state import FIELDS
from neve.scene.schema.scene import Scene

if TYPE_CHECKING:
    from neve._core import Report, State

ROOM = 1.25
"""Particles that there is made room for, over those that there are."""
LEAST_ROOM = 4096

Array = NDArray[np.float64]


class OpenState(OpenSnow):
    """Add to a state and take out of it.

    Attributes:
        state: as it is now; another one where there was no room for more
    """

    def __init__(self, scene: Scene, model: Model, state: State) -> None:
        self._scene = scene
        self._model = model
        self.state = state

    @property
    def count(self) -> int:
        """Number of particles."""
        return self.state.count

    def bytes_with(self, count: int) -> float:
        """Return the memory of a state with room for `count` particles [bytes], 0 if this one has it."""
        if count <= self.state.capacity:
            return 0.0
        return self.state.bytes * _room_for(count) / max(self.state.capacity, 1)

    def append(self, columns: Mapping[str, NDArray[Any]], emitter: int, ids: NDArray[np.uint32]) -> None:
        """Add particles after the others, in a new state if there is no room."""
        before, count = self.state.count, len(ids)
        if before + count > self.state.capacity:
            self.state = self.state.with_room(_room_for(before + count))
        state = self.state
        state.append(count)
        for name, values in columns.items():
            getattr(state, name)[before:] = values
        if self._model.is_fine:
            state.beyond[before:] = columns["x"] - state.x[before:]
        if self._model.has_heat:
            state.enthalpy[before:, 0] = enthalpy_at(self._scene, columns["m"])
        state.id[before:] = ids

    def positions(self, low: Array, high: Array) -> tuple[NDArray[np.uint32], Array]:
        """Return the rows from `low` to `high` (3,) [m], and where they are (n, 3) [m]."""
        rows = self.state.rows_in_box(low, high)
        return rows, np.asarray(self.state.x[rows], np.float64)

    def drop(self, rows: NDArray[np.uint32]) -> None:
        """Take out particles; what lies within two blocks of them wakes: all that shared a node with them."""
        state = self.state
        if self._model.sleeps:
            x, far = np.asarray(state.x[rows], np.float64), 8.0 * self._scene.numerics.dx
            state.rest[state.rows_in_box(x.min(axis=0) - far, x.max(axis=0) + far)] = 0.0
        state.drop(rows)

    def sums(self, rows: NDArray[Any]) -> Array:
        """Return mass, momentum and energy of the particles at `rows` (5,), in double by birth."""
        state = self.state
        rows = rows[np.argsort(state.id[rows])]
        some = self._model.particles(len(rows))
        for field in FIELDS:
            getattr(some, field.name)[...] = getattr(state, field.name)[rows]
        t = self._model.core.totals(self._model.native, some)
        return np.array([t.mass, *t.momentum, t.kinetic + t.affine + t.elastic + t.potential])


def _room_for(count: int) -> int:
    """Return for how many particles a state is made that is to hold `count`."""
    return int(ROOM * count) + LEAST_ROOM


def birth_report(flow: Flow, model: Model) -> Report | None:
    """Return what a pass over a particle of each emitter finds at birth; None without emitters."""
    newborn = flow.at_birth()
    if not newborn:
        return None
    some = model.particles(len(newborn))
    for i, snow in enumerate(newborn):
        some.v[i] = snow.v
        some.m[i], some.V0[i] = snow.mass, snow.volume
        some.material[i] = snow.material
    return model.core.refresh(model.native, some)
