"""Whose snow a particle is: the numbers of particles in the order of birth, and who gave birth to them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST = 2**32
"""Particles that may be born in a run: so many numbers there are."""


class Births:
    """Hold which source or emitter bore which particles.

    Particles are numbered on as they are born, and a number is never given twice. Rows (first, owner) say
    that the particles from number `first` on, up to that of the next row, are of a source (its number), or of
    an emitter (-1 less its number).

    Attributes:
        count: how many particles were ever born
    """

    def __init__(self, rows: list[tuple[int, int]], count: int) -> None:
        self._rows = rows
        self._table: NDArray[np.int64] | None = None
        self.count = count

    @classmethod
    def of_sources(cls, sizes: list[int]) -> Births:
        """Return the births of a scene whose sources have so many particles each."""
        begins = np.cumsum([0, *sizes])
        return cls([(int(first), i) for i, first in enumerate(begins[:-1])], int(begins[-1]))

    @classmethod
    def of_arrays(cls, rows: Any, count: Any, sources: int, emitters: int) -> Births:
        """Return what `arrays` gave. Errors: ValueError for what belongs to no state of such a scene."""
        table = np.array(rows)
        right = table.ndim == 2 and table.shape[1:] == (2,) and table.dtype == np.int64
        if right and len(table):
            first, owner = table[:, 0], table[:, 1]
            right = bool(
                first[0] == 0
                and np.all(np.diff(first) >= 0)
                and first[-1] <= int(count)
                and np.all((owner >= -emitters) & (owner < sources))
                and set(range(sources)) <= {*owner.tolist()}
            )
        right = right and (len(table) > 0 or sources == 0)
        if not right or not 0 <= int(count) <= MOST:
            raise ValueError(f"births is an array {table.shape} of {table.dtype}, not those of this scene")
        return cls([(int(first), int(owner)) for first, owner in table], int(count))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all that a resume needs."""
        return {"births": self.table.copy(), "born": np.array(self.count, np.int64)}

    @property
    def table(self) -> NDArray[np.int64]:
        """The rows (k, 2)."""
        if self._table is None:
            self._table = np.array(self._rows, np.int64).reshape(-1, 2)
        return self._table

    def add(self, owner: int, count: int) -> NDArray[np.uint32]:
        """Name `count` more particles of `owner` and return their numbers (count,)."""
        first = self.count
        if not self._rows or self._rows[-1][1] != owner or owner >= 0:
            self._rows.append((first, owner))
            self._table = None
        self.count += count
        return np.arange(first, self.count, dtype=np.uint32)

    def copy(self) -> Births:
        """Return births that can go another way."""
        return Births(list(self._rows), self.count)

    def of(self, ids: NDArray[Any], sources: int) -> NDArray[Any]:
        """Return whose the particles `ids` (n,) are: a source's number, or `sources` plus an emitter's."""
        first, owner = self.table[:, 0], self.table[:, 1]
        whose = np.where(owner < 0, sources - 1 - owner, owner)
        if not len(ids):
            return np.zeros(0, np.uint16)
        found = whose[np.searchsorted(first, ids, side="right") - 1]
        return np.asarray(found.astype(np.uint16 if sources <= 2**15 else np.uint32))
