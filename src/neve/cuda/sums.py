"""Sums over the particles on the GPU, and whether they are such as snow can be."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from neve.cuda.driver import Driver
from neve.cuda.layout import SUMS, summed
from neve.cuda.memory import Buffer


class DeviceTotals(NamedTuple):
    """Sums over the state; see `neve._core.Totals`. There is no heat on a GPU."""

    mass: float
    momentum: list[float]
    kinetic: float
    affine: float
    elastic: float
    potential: float
    heat: float = 0.0
    water: float = 0.0


class Sums:
    """Where kernels sum up."""

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self._buffer = Buffer(driver, SUMS.itemsize)

    def clear(self) -> int:
        """Forget what was summed; return where it is summed anew."""
        self._driver.fill(self._buffer.address, 0, SUMS.itemsize)
        return self._buffer.address

    def read(self) -> Any:
        """Return what was summed, when it is done."""
        out = np.zeros(1, SUMS)
        self._driver.download(out.ctypes.data, self._buffer.address, SUMS.itemsize)
        return out[0]


def totals_of(found: Any, deterministic: bool) -> DeviceTotals:
    """Return the sums of `add_up`."""
    numbers = summed(found["number"], deterministic)[:8]
    mass, px, py, pz, kinetic, affine, elastic, potential = numbers.tolist()
    return DeviceTotals(mass, [px, py, pz], kinetic, affine, elastic, potential)


def densest_of(found: Any) -> tuple[int, float] | None:
    """Return the row of the densest particle and its density over that of ice; None in case of doubt."""
    if found["doubtful"]:
        return None
    key = int(found["densest"])
    if key == 0:
        return -1, 0.0
    return ~key & 0xFFFFFFFF, float(np.uint32(key >> 32).view(np.float32))
