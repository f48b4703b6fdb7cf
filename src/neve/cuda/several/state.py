"""The particles of a run on several GPUs: each has those of its domain, and NumPy sees all of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from neve.cuda.driver import Driver
from neve.cuda.state import FIELDS, DeviceState
from neve.domains.partition import Slabs, balanced

if TYPE_CHECKING:
    from neve._core import State

BLOCK_CELLS, FIRST_CELL = 4, 1.5
"""Cells of a block along an axis, and where block 0 begins, but for half a cell more or less [cells]."""


class DomainState:
    """The particles of a run as `DeviceState` has them, the rows of one domain after those of another.

    Attributes:
        host: all of them, in the core; parts: those on each GPU
        partition: which domain owns a block; chosen by the particles when they are first copied, and kept
    """

    def __init__(self, drivers: Sequence[Driver], host: State) -> None:
        """Divide `host` evenly, until there are positions. Errors: DeviceError as `DeviceState`."""
        self.host = host
        self.partition: Slabs | None = None
        ends = [host.count * k // len(drivers) for k in range(len(drivers) + 1)]
        self.parts = [
            DeviceState(driver, host, ends[k], ends[k + 1] - ends[k]) for k, driver in enumerate(drivers)
        ]

    @property
    def count(self) -> int:
        """Number of particles."""
        return self.host.count

    @property
    def bytes(self) -> int:
        """Memory on all GPUs [bytes]."""
        return sum(part.bytes for part in self.parts)

    def upload(self, dx: float) -> None:
        """Copy what may have been written to; at first, choose the partition. dx: of the grid [m]."""
        if self.partition is None:
            self._divide(dx)
        for part in self.parts:
            part.upload()

    def _divide(self, dx: float) -> None:
        """Choose the partition, and put the rows of each domain together.

        Who is in the first half of a border block or not decides the sort on the GPU, by the spline.
        """
        x = np.asarray(self.host.x, np.float64)
        cells = np.nan_to_num((x / dx - FIRST_CELL) / BLOCK_CELLS, posinf=0.0, neginf=0.0)
        blocks = np.floor(np.clip(cells, -(2.0**20), 2.0**20)).astype(np.int32)
        self.partition = balanced(blocks, len(self.parts))
        owner = self.partition.owner(blocks)
        order = np.argsort(owner, kind="stable")
        for name in FIELDS:
            array = getattr(self.host, name)
            array[...] = array[order]
        for part, count in zip(self.parts, np.bincount(owner, minlength=len(self.parts)), strict=True):
            part.reserve(int(count))
            part.count = int(count)
        self.place_rows()

    def place_rows(self) -> None:
        """Let the rows of each domain in `host` follow those of the one before."""
        first = 0
        for part in self.parts:
            part.first, first = first, first + part.count

    def moved(self, names: tuple[str, ...] = FIELDS) -> None:
        """Say that fields have changed on the GPUs."""
        for part in self.parts:
            part.moved(names)

    def whole(self) -> State:
        """Return the core's state, all of it as on the GPUs; to be looked at only."""
        for part in self.parts:
            part.whole()
        return self.host

    def shown(self, name: str) -> Any:
        """Return a field, only to be looked at: no `upload` follows."""
        for part in self.parts:
            part.shown(name)
        return getattr(self.host, name)

    def __getattr__(self, name: str) -> Any:
        if name in ("beyond", "rest", "enthalpy", "thermal"):
            return getattr(self.host, name)  # no columns: nothing sleeps or has heat here
        if name not in FIELDS:
            raise AttributeError(name)
        for part in self.parts:
            part.field(name)
        return getattr(self.host, name)
