"""The particles on the GPU, seen from NumPy through arrays of the core that follow when asked for."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from neve.cuda.driver import Driver
from neve.cuda.errors import DeviceError
from neve.cuda.layout import MODE_COLUMNS, NUMBERS, VECTORS, Particles
from neve.cuda.memory import SLACK, Buffer
from neve.system.memory import in_words

if TYPE_CHECKING:
    from neve._core import State

FIELDS = (*VECTORS, *NUMBERS, "modes", "material", "id")
"""All fields of the state."""
SORTING_BYTES = 20
"""What sorting takes of a particle [bytes]."""
SPARE = 1.25
"""What particles and sorting take, times this, is asked for: nodes take the rest, but of snow in the air."""
LINE = 32
"""Columns begin at multiples of so many particles."""


class DeviceState:
    """The particles of a run: `neve._core.State`, whose columns also lie on the GPU.

    A field that is asked for is copied from the GPU if it has changed there, and back again at the next
    `upload`, since the array may have been written to. Arrays that were handed out before a step do not
    follow it: ask for the field again.

    Attributes:
        count: particles here: all of `host`, or as many of its rows from `first` on
        sorted: how often the columns have changed their places
    """

    def __init__(self, driver: Driver, host: State, first: int = 0, count: int | None = None) -> None:
        """Take over `host`, or a part of it. Errors: DeviceError if the GPU has not enough memory."""
        self.host = host
        self.first = first
        self.count = host.count if count is None else count
        self.sorted = 0
        self._driver = driver
        self._newer_here = set(FIELDS)  # or perhaps written to
        self._newer_there: set[str] = set()
        self._real = host.x.dtype.itemsize
        self._columns = {name: len(self._host_columns(name)) for name in FIELDS}
        self._spare: dict[int, int] = {}
        self._buffers = self._allocate(self.count)

    def _allocate(self, room: int) -> list[Buffer]:
        """Give each column a place for `room` rows, and one more for each width of numbers, for sorting."""
        self._stride = -(-room // LINE) * LINE
        if self._columns["modes"] > MODE_COLUMNS:
            raise DeviceError(f"a particle has {self._columns['modes']} numbers of velocity modes")
        widths = {name: self._width(name) for name in FIELDS}
        columns = {w: [n for n in FIELDS if widths[n] == w] for w in set(widths.values())}
        sizes = {
            w: (sum(self._columns[n] for n in names) + 1) * w * self._stride for w, names in columns.items()
        }
        self._require(sum(sizes.values()), room)
        self._at: dict[str, list[int]] = {}
        buffers = []
        for width, names in columns.items():
            buffer = Buffer(self._driver, sizes[width])
            address = buffer.address
            for name in names:
                self._at[name] = [address + k * width * self._stride for k in range(self._columns[name])]
                address += self._columns[name] * width * self._stride
            self._spare[width] = address
            buffers.append(buffer)
        return buffers

    def _require(self, size: int, room: int) -> None:
        """Refuse more particles than there is memory for, and say how many fit."""
        free, _ = self._driver.memory()
        needed = SPARE * (size + SORTING_BYTES * room)
        if needed <= free:
            return
        fits = int(room * free / needed)
        finer = (room / max(fits, 1)) ** (1 / 3)
        raise DeviceError(
            f"{room} particles need about {in_words(needed)} on {self._driver.name}, where "
            f"{in_words(free)} are free: about {fits} fit, so raise numerics.dx {finer:.3g} times"
        )

    def _width(self, name: str) -> int:
        return {"material": 2, "id": 4}.get(name, self._real)

    def _host_columns(self, name: str) -> list[Any]:
        """Return the columns of a field of the core's state, each one piece of memory, as addresses."""
        array = self._rows(name)
        if array.ndim == 1:
            return [array.ctypes.data]
        if name == "modes":
            return [array[:, k, a].ctypes.data for k in range(array.shape[1]) for a in range(3)]
        if array.ndim == 2:
            return [array[:, k].ctypes.data for k in range(array.shape[1])]
        return [array[:, k % 3, k // 3].ctypes.data for k in range(9)]

    def _rows(self, name: str) -> Any:
        """Return the rows of a field that are here, in the core's state."""
        array = getattr(self.host, name)
        return array[self.first : self.first + self.count]

    # Particles that come and go

    def reserve(self, room: int) -> None:
        """Have room for `room` rows; those that are here are kept. Errors: DeviceError."""
        if room <= self._stride:
            return
        before, there, kept = self._buffers, self._at, self.count
        self._buffers = self._allocate(room)
        for name, columns in there.items():
            for old, new in zip(columns, self._at[name], strict=True):
                self._driver.copy(new, old, self._width(name) * kept)
        del before  # not earlier: it was read
        self.sorted += 1

    @property
    def row_bytes(self) -> int:
        """Memory of a particle [bytes]."""
        return sum(self._width(name) * count for name, count in self._columns.items())

    def take(self, to: int, first: int, count: int) -> None:
        """Copy rows from `first` on to the address `to`, one column after another."""
        for width, column in self._each_place():
            self._driver.copy(to, column + width * first, width * count)
            to += width * count

    def append(self, source: int, count: int) -> None:
        """Add rows that `take` has copied, after all others. Errors: DeviceError."""
        if self.count + count > self._stride:
            self.reserve(int(SLACK * (self.count + count)))
        for width, column in self._each_place():
            self._driver.copy(column + width * self.count, source, width * count)
            source += width * count
        self.count += count

    def _each_place(self) -> Iterator[tuple[int, int]]:
        """Yield the width [bytes] and the address of each column, the wider ones first."""
        for name in sorted(FIELDS, key=lambda name: -self._width(name)):
            for column in self._at[name]:
                yield self._width(name), column

    # Copies

    def upload(self) -> None:
        """Copy what may have been written to here."""
        for name in self._newer_here:
            size = self._width(name) * self.count
            for there, here in zip(self._at[name], self._host_columns(name), strict=True):
                if size:
                    self._driver.upload(there, here, size)
        self._newer_here.clear()

    def moved(self, names: tuple[str, ...] = FIELDS) -> None:
        """Say that fields have changed on the GPU."""
        self._newer_there.update(names)
        self._newer_here.difference_update(names)

    def download(self, name: str) -> None:
        """Copy a field here if it has changed on the GPU."""
        if name not in self._newer_there:
            return
        size = self._width(name) * self.count
        for there, here in zip(self._at[name], self._host_columns(name), strict=True):
            if size:
                self._driver.download(here, there, size)
        self._newer_there.discard(name)

    def whole(self) -> State:
        """Return the core's state, all of it as on the GPU; to be looked at only."""
        for name in FIELDS:
            self.download(name)
        return self.host

    # What kernels are given

    def fill(self, to: Particles) -> None:
        """Say where the columns are."""
        for name, count in VECTORS.items():
            setattr(to, name, (ctypes.c_uint64 * count)(*self._at[name]))
        for name in (*NUMBERS, "material", "id"):
            setattr(to, name, self._at[name][0])
        to.modes = (ctypes.c_uint64 * MODE_COLUMNS)(*self._at["modes"])

    def each_column(self) -> Any:
        """Yield for each column its width [bytes], its address and where to permute it to.

        After each the two places are exchanged. The stress follows from the rest, but is kept as well.
        """
        self.sorted += 1
        for name in FIELDS:
            width = self._width(name)
            for k, address in enumerate(self._at[name]):
                yield width, address, self._spare[width]
                self._at[name][k], self._spare[width] = self._spare[width], address

    @property
    def bytes(self) -> int:
        """Memory on the GPU [bytes]."""
        return sum(buffer.size for buffer in self._buffers)

    def __getattr__(self, name: str) -> Any:
        if name in ("beyond", "rest", "enthalpy", "thermal"):
            return getattr(self.host, name)  # no columns: nothing sleeps or has heat here
        if name not in FIELDS:
            raise AttributeError(name)
        return self.field(name)

    def shown(self, name: str) -> Any:
        """Return the rows of a field that are here, only to be looked at: no `upload` follows."""
        self.download(name)
        return self._rows(name)

    def field(self, name: str) -> Any:
        """Return the rows of a field that are here, to be looked at or written to until the next `upload`."""
        self.download(name)
        self._newer_here.add(name)
        return self._rows(name)
