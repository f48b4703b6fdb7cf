"""Particles in contact as snow that comes and goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.build import PlacedSolids
from neve.flow.flow import OpenSnow
from neve.heat.enthalpy import enthalpy_at
from neve.particles.constants import radius_at_birth
from neve.scene.schema.scene import Scene

if TYPE_CHECKING:
    from neve._core import Particles

Array = NDArray[np.float64]


class OpenParticles(OpenSnow):
    """Add to particles and take out of them. Each change makes others, in memory of their own.

    What comes is bonded to what it is born beside, as it lies, by `settle`: so it is born without stress.

    Attributes:
        state: as they are now; settled: whether their pairs are listed
    """

    def __init__(
        self,
        scene: Scene,
        placed: PlacedSolids,
        state: Particles,
        list_pairs: Callable[[Particles, int | None], None],
    ) -> None:
        """Take the particles of a scene as they are.

        list_pairs: lists the pairs of particles, and bonds those of birth numbers from that on, if any.
        """
        self._scene = scene
        self._placed = placed
        self._list_pairs = list_pairs
        self._newborn: int | None = None
        self.state = state
        self.settled = True

    @property
    def count(self) -> int:
        """Number of particles."""
        return self.state.count

    def bytes_with(self, count: int) -> float:
        """Return the memory of `count` particles [bytes]."""
        return self.state.bytes / max(self.state.count, 1) * count

    def append(self, columns: Mapping[str, NDArray[Any]], emitter: int, ids: NDArray[np.uint32]) -> None:
        """Add particles after the others."""
        before, count = self.state.count, len(ids)
        self._replace(np.arange(before, dtype=np.uint32), count)
        state = self.state
        for name, values in columns.items():
            getattr(state, name)[before:] = values
        state.id[before:] = ids
        state.source[before:] = len(self._scene.sources) + emitter
        state.radius[before:] = radius_at_birth(float(columns["V0"][0]))
        state.enthalpy[before:] = enthalpy_at(self._scene, np.asarray(state.m[before:]))
        if self._newborn is None:
            self._newborn = int(ids[0])

    def positions(self, low: Array, high: Array) -> tuple[NDArray[np.uint32], Array]:
        """Return the rows from `low` to `high` (3,) [m], and where they are (n, 3) [m]."""
        self.settle()
        x = np.asarray(self.state.x, np.float64)
        rows = np.flatnonzero(np.all((low <= x) & (x <= high), axis=1)).astype(np.uint32)
        return rows, x[rows]

    def drop(self, rows: NDArray[np.uint32]) -> None:
        """Take out particles; what was bonded to them or touched them wakes."""
        kept = np.delete(np.arange(self.state.count, dtype=np.uint32), rows)
        self._replace(kept, 0)

    def sums(self, rows: NDArray[Any]) -> Array:
        """Return mass, momentum and energy of the particles at `rows` (5,), in double by birth; bonds and
        contacts with others count in full.
        """
        rows = rows[np.argsort(self.state.id[rows])].astype(np.uint32)
        t = self.state.totals_of(self._placed.native, rows)
        return np.array([t.mass, *t.momentum, t.kinetic + t.elastic + t.potential])

    def settle(self) -> None:
        """List the pairs of what has changed, and bond what has come. Errors: Blowup."""
        if not self.settled:
            self._list_pairs(self.state, self._newborn)
        self.settled, self._newborn = True, None

    def _replace(self, kept: NDArray[np.uint32], more: int) -> None:
        self.state = self.state.with_particles(kept, more)
        self.settled = False
