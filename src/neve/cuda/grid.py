"""The sparse grid on the GPU: homes, blocks of nodes, and what sorting needs."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.cuda.driver import Driver
from neve.cuda.layout import (
    BLOCK_NODES,
    COORD_BYTES,
    EXCHANGE_NUMBERS,
    HOME,
    RESULTS,
    Nodes,
    Sorting,
    Table,
    bounds_bytes,
    sum_bytes,
    summed,
)
from neve.cuda.memory import Buffer

if TYPE_CHECKING:
    from neve.cuda.model import DeviceModel

FIRST_CAPACITY = 1024
"""Slots of a table of blocks before it has to grow."""


class BlockTable:
    """A hash table of blocks: at least twice as many slots as blocks."""

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self.capacity = FIRST_CAPACITY
        self._keys, self._value, self._list = Buffer(driver), Buffer(driver), Buffer(driver)

    def clear(self, to: Table, count: int) -> None:
        """Empty it; count: the address of its counter, which is 0."""
        self._keys.require(8 * self.capacity, slack=1.0)
        self._value.require(4 * self.capacity, slack=1.0)
        self._list.require(8 * self.capacity, slack=1.0)
        self._driver.fill(self._keys.address, 0xFF, 8 * self.capacity)
        to.keys, to.value, to.list = self._keys.address, self._value.address, self._list.address
        to.count, to.capacity = count, self.capacity
        to.shift = 64 - (self.capacity.bit_length() - 1)

    @property
    def bytes(self) -> int:
        """Memory [bytes]."""
        return self._keys.size + self._value.size + self._list.size


class DeviceGrid:
    """The grid of a run on the GPU.

    Attributes:
        current: no particle has left its home since the last sort
        homes: blocks that own particles; blocks: of 64 nodes
        count: particles sorted; lightest: mass of the lightest [kg]
        scattered: the last g2p has scattered for the next step; turn: how often that was taken
        ghosts: address of a flag for each block, whether another domain counts it; 0: none does
    """

    def __init__(self, driver: Driver, precision: str, deterministic: bool = False) -> None:
        self._driver, self._deterministic = driver, deterministic
        self._bytes = 4 if precision == "float32" else 8
        self._bounds_bytes = bounds_bytes(precision)
        self.current, self.homes, self.blocks, self.count, self.lightest = False, 0, 0, 0, 0.0
        self.ghosts = self.turn = 0
        self.scattered = False
        self.home_table, self.block_table = BlockTable(driver), BlockTable(driver)
        self._results = Buffer(driver, RESULTS.itemsize)
        self._parts: dict[str, Buffer] = {}
        self._exchanged, self._accepted = Buffer(driver), Buffer(driver)
        self._taken = np.zeros((0, EXCHANGE_NUMBERS))

    def _part(self, name: str, size: int) -> int:
        """Return the address of a part that has room for `size` bytes."""
        if name not in self._parts:
            self._parts[name] = Buffer(self._driver)
        self._parts[name].require(size)
        return self._parts[name].address

    # Sorting

    def fill_sorting(self, to: Sorting, count: int) -> None:
        """Give room to sort `count` particles."""
        to.home_of, to.place = self._part("home_of", 4 * count), self._part("place", 4 * count)
        to.order, to.key = self._part("order", 4 * count), self._part("key", 8 * count)

    def fill_homes(self, to: Nodes) -> None:
        """Give room for the homes."""
        to.homes = self._part("homes", HOME.itemsize * self.homes)

    def fill_nodes(self, to: Nodes, model: DeviceModel) -> None:
        """Give room for the nodes of all blocks."""
        to.at = self._part("at", COORD_BYTES * self.blocks)
        to.bounds = self._part("bounds", self._bounds_bytes * self.blocks)
        to.node = self._part("node", self.node_bytes)
        to.change = self._part("change", self.node_bytes) if model.has_force else 0
        to.lift = self._part("lift", self.node_bytes) if model.has_play else 0
        to.next, to.next_force = (
            self._part(name, self.node_bytes) if model.is_fused else 0 for name in ("next", "next_force")
        )
        to.ghosts = self.ghosts

    def take_next(self) -> None:
        """Let what `g2p2g` has scattered be the nodes."""
        for name, other in (("node", "next"), ("change", "next_force")):
            self._parts[name], self._parts[other] = self._parts[other], self._parts[name]
        self.turn, self.scattered = self.turn + 1, False

    @property
    def node_bytes(self) -> int:
        """Memory of four numbers for each node [bytes]."""
        return 4 * self._bytes * BLOCK_NODES * self.blocks

    @property
    def bytes(self) -> int:
        """Memory on the GPU [bytes]."""
        parts = sum(buffer.size for buffer in self._parts.values())
        return parts + self.home_table.bytes + self.block_table.bytes

    # Results

    def clear_results(self) -> int:
        """Forget what stages have found; return where they write it."""
        self._driver.fill(self._results.address, 0, RESULTS.itemsize)
        return self._results.address

    def results(self) -> dict[str, Any]:
        """Return what stages have found, when they are done."""
        out = np.zeros(1, RESULTS)
        self._driver.download(out.ctypes.data, self._results.address, RESULTS.itemsize)
        return {name: out[name][0] for name in RESULTS.names or ()}

    def counter(self, name: str) -> int:
        """Return the address of a counter among the results."""
        fields = RESULTS.fields
        assert fields is not None
        return self._results.address + fields[name][1]

    # Exchange with solids

    def exchanged(self, solids: int) -> int:
        """Return where is summed what snow and solids exchange in an attempt at a step."""
        if solids != len(self._taken):
            self._taken = np.zeros((solids, EXCHANGE_NUMBERS))
            self._exchanged.require(self._exchanged_bytes)
        return self._exchanged.address

    @property
    def _exchanged_bytes(self) -> int:
        return sum_bytes(self._deterministic) * self._taken.size

    def begin_attempt(self) -> None:
        """Forget what the last attempt at a step has exchanged: it may have been rejected."""
        self._driver.fill(self._exchanged.address, 0, self._exchanged_bytes)

    def accept_attempt(self) -> None:
        """Count what this attempt has exchanged."""
        self.count_exchange(self.attempt())

    def attempt(self) -> NDArray[np.uint64]:
        """Return what this attempt has exchanged, as words of `Sum`, when it is done."""
        return self._read(self._exchanged)

    def _read(self, sums: Buffer) -> NDArray[np.uint64]:
        raw = np.zeros(self._exchanged_bytes // 8, np.uint64)
        if len(raw):
            self._driver.download(raw.ctypes.data, sums.address, raw.nbytes)
        return raw

    def count_exchange(self, raw: NDArray[np.uint64]) -> None:
        """Add what `attempt` returned to what is taken."""
        if len(raw):
            self._taken += summed(raw, self._deterministic).reshape(self._taken.shape)

    def begin_ahead(self) -> int:
        """Forget attempts; return where is summed what the steps that are taken exchange."""
        self.begin_attempt()
        self._accepted.require(self._exchanged_bytes)
        self._driver.fill(self._accepted.address, 0, self._exchanged_bytes)
        return self._accepted.address

    def end_ahead(self) -> None:
        """Count what these steps have exchanged."""
        self.count_exchange(self._read(self._accepted))

    def take_exchanged(self, solids: int) -> NDArray[np.float64]:
        """Return what snow and each solid exchanged since the last call, (solids, 7)."""
        taken = self._taken if len(self._taken) == solids else np.zeros((solids, EXCHANGE_NUMBERS))
        self._taken = np.zeros_like(self._taken)
        return taken

    def block_coords(self) -> NDArray[np.int32]:
        """Return the coordinates of the blocks of nodes, (n, 3)."""
        at = np.zeros((self.blocks, 3), np.int32)
        if self.blocks:
            self._driver.download(at.ctypes.data, self._parts["at"].address, at.nbytes)
        return at

    def home_nodes(self) -> NDArray[np.int32]:
        """Return the numbers of the eight blocks of nodes that each home covers, (n, 8)."""
        homes = np.zeros(self.homes, HOME)
        if self.homes:
            self._driver.download(homes.ctypes.data, self._parts["homes"].address, homes.nbytes)
        return np.asarray(homes["nodes"])

    def nodes(self) -> tuple[NDArray[np.int32], NDArray[Any], NDArray[Any]]:
        """Return the nodes that carry mass: indices (n, 3), mass (n,), the three other numbers (n, 3)."""
        real = np.float32 if self._bytes == 4 else np.float64
        values = np.zeros((self.blocks * BLOCK_NODES, 4), real)
        if self.blocks:
            self._driver.download(values.ctypes.data, self._parts["node"].address, values.nbytes)
        at = self.block_coords()
        n = np.arange(BLOCK_NODES)
        inside = np.stack([n // 16, n // 4 % 4, n % 4], axis=1).astype(np.int32)
        ijk = (4 * at[:, None, :] + inside[None]).reshape(-1, 3)
        there = values[:, 3] > 0
        return ijk[there], values[there, 3], values[there, :3]


def solids_of(model: DeviceModel, grid: DeviceGrid, step: ctypes.Structure) -> None:
    """Tell a step of the solids."""
    step.solids, step.solid_count = model.solids()
    step.exchanged = grid.exchanged(step.solid_count)
