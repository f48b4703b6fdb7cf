"""The grids of a run on several GPUs: a `DeviceGrid` on each, and which of its blocks others have too."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.cuda.driver import Driver
from neve.cuda.grid import DeviceGrid
from neve.cuda.layout import ALL_COLOURS
from neve.cuda.memory import Buffer
from neve.domains.halo import Halo, Rows, given_by, halos, routes
from neve.domains.partition import Slabs
from neve.domains.transport import Route, Transport

Listed = tuple[int, int]
"""A list on a GPU: its address, and how many numbers it has."""
NOTHING: Listed = (0, 0)
UNION, BORDER, INTERIOR, GHOSTS = "union", "border", "interior", "ghosts"
"""Names of lists: blocks that a domain shares; homes that cover such blocks, and those that do not; a flag
for each block."""


class DeviceLists:
    """Lists of blocks or homes on one GPU, by what they are for."""

    def __init__(self, driver: Driver) -> None:
        self._driver, self._buffer = driver, Buffer(driver)
        self._at: dict[Hashable, Listed] = {}

    def write(self, lists: Mapping[Hashable, Rows | NDArray[np.bool_]]) -> None:
        """Copy lists to the GPU, in place of those that were there."""
        every = np.concatenate([np.zeros(0, np.int32), *(rows.astype(np.int32) for rows in lists.values())])
        self._buffer.require(every.nbytes)
        if every.size:
            self._driver.upload(self._buffer.address, every.tobytes(), every.nbytes)
        self._at, address = {}, self._buffer.address
        for name, rows in lists.items():
            self._at[name] = (address, len(rows))
            address += 4 * len(rows)

    def __getitem__(self, name: Hashable) -> Listed:
        return self._at.get(name, NOTHING)


def total_of_sums(
    transport: Transport, raw: Sequence[NDArray[np.uint64]], deterministic: bool
) -> NDArray[np.uint64]:
    """Return the sums of `Sum`s over all domains, as words of `Sum` again."""
    if deterministic:
        return transport.total(raw)
    return transport.total([words.view(np.float64) for words in raw]).view(np.uint64)


class DomainGrid:
    """The grid of a run on several GPUs, as `DeviceGrid` has it.

    Attributes:
        parts: on each GPU; lists: of the blocks that each shares, and of its homes
        routes: who sends nodes to whom
        current: no particle has left its home since the last sort; count: particles sorted
        blocks: of 64 nodes, each counted once; homes: blocks that own particles
    """

    def __init__(self, drivers: Sequence[Driver], precision: str, deterministic: bool) -> None:
        self.parts = [DeviceGrid(driver, precision, deterministic) for driver in drivers]
        self.lists = [DeviceLists(driver) for driver in drivers]
        self.routes: Sequence[Route] = ()
        self._drivers, self._deterministic = drivers, deterministic
        self._packed: dict[Route, Buffer] = {}
        self._arriving: dict[Route, Buffer] = {}
        self.current, self.count, self.blocks = False, 0, 0

    @property
    def homes(self) -> int:
        """Blocks that own particles."""
        return sum(part.homes for part in self.parts)

    @property
    def bytes(self) -> int:
        """Memory on all GPUs [bytes]."""
        return sum(part.bytes for part in self.parts)

    def lay_out(self, partition: Slabs, transport: Transport) -> None:
        """Find the blocks that domains share, after all have sorted."""
        found = halos(partition, transport, {d: part.block_coords() for d, part in enumerate(self.parts)})
        self.routes = routes(found)
        lightest = min((part.lightest for part in self.parts if part.homes), default=0.0)
        for d, (part, lists) in enumerate(zip(self.parts, self.lists, strict=True)):
            lists.write(self._lists_of(found, d, part))
            part.lightest = lightest
            part.ghosts = lists[GHOSTS][0]
        self.blocks = sum(int((~halo.ghosts).sum()) for halo in found.values())

    def _lists_of(self, found: Mapping[int, Halo], d: int, part: DeviceGrid) -> dict[Hashable, Any]:
        """Return the lists of one domain by name; a route means what goes along it."""
        halo = found[d]
        out: dict[Hashable, Any] = {GHOSTS: halo.ghosts, UNION: halo.union}
        at_border = np.zeros(len(halo.ghosts), bool)
        at_border[halo.union] = True
        touches = at_border[part.home_nodes()].any(axis=1)
        out[BORDER], out[INTERIOR] = np.flatnonzero(touches), np.flatnonzero(~touches)
        for e, rows in halo.shared.items():
            out[d, e] = out[e, d] = rows
            for colour in range(ALL_COLOURS if self._deterministic else 0):
                out[d, e, colour] = given_by(halo, rows, d, colour)
                out[e, d, colour] = given_by(halo, rows, e, colour)
        return out

    def packed(self, route: Route, size: int) -> int:
        """Return the address on the GPU of a route's sender for `size` bytes."""
        return self._room(self._packed, route, self._drivers[route[0]], size)

    def arriving(self, route: Route, size: int) -> int:
        """Return the address on the GPU of a route's receiver for `size` bytes."""
        return self._room(self._arriving, route, self._drivers[route[1]], size)

    @staticmethod
    def _room(buffers: dict[Route, Buffer], route: Route, driver: Driver, size: int) -> int:
        if route not in buffers:
            buffers[route] = Buffer(driver)
        buffers[route].require(size)
        return buffers[route].address

    # Exchange with solids

    def accept_attempt(self, transport: Transport) -> None:
        """Count what this attempt at a step has exchanged with solids, over all domains."""
        raw = [part.attempt() for part in self.parts]
        self.parts[0].count_exchange(total_of_sums(transport, raw, self._deterministic))

    def take_exchanged(self, solids: int) -> NDArray[np.float64]:
        """Return what snow and each solid exchanged since the last call, (solids, 7)."""
        return self.parts[0].take_exchanged(solids)

    def nodes(self) -> tuple[NDArray[np.int32], NDArray[Any], NDArray[Any]]:
        """Return the nodes that carry mass: indices (n, 3), mass (n,), the three other numbers (n, 3)."""
        found = [part.nodes() for part in self.parts]
        ijk, m, rest = (np.concatenate(each) for each in zip(*found, strict=True))
        _, first = np.unique(ijk, axis=0, return_index=True)
        return ijk[first], m[first], rest[first]
