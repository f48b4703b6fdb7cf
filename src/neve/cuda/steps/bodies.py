"""Bodies that the snow moves: what the GPU says of their contacts with snow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.cuda.driver import Driver
from neve.cuda.layout import RESPONSE_NUMBERS, Bodies, sum_bytes, summed
from neve.cuda.memory import Buffer


class DeviceBodies:
    """Where kernels read how bodies may move, and write what the snow would do to them then."""

    def __init__(self, driver: Driver, deterministic: bool) -> None:
        self._driver, self._deterministic = driver, deterministic
        self._waiting, self._velocity, self._response = Buffer(driver), Buffer(driver), Buffer(driver)
        self._count = 0

    def fill(self, to: Bodies, blocks: int) -> None:
        """Give room for `to.count` bodies among so many blocks of nodes."""
        self._count = to.count
        self._waiting.require(4 * blocks)
        self._velocity.require(6 * 8 * self._count)
        self._response.require(self._response_bytes)
        to.waiting, to.velocity = self._waiting.address, self._velocity.address
        to.response = self._response.address

    def move(self, U: NDArray[np.float64]) -> None:
        """Let the bodies move with U (b, 6) [m/s, 1/s], and forget what the snow does to them."""
        self._driver.upload(self._velocity.address, np.ascontiguousarray(U).tobytes(), U.nbytes)
        self._driver.fill(self._response.address, 0, self._response_bytes)

    def raw(self) -> NDArray[np.uint64]:
        """Return what the snow here does to each body, as words of `Sum`."""
        raw = np.zeros(self._response_bytes // 8, np.uint64)
        self._driver.download(raw.ctypes.data, self._response.address, raw.nbytes)
        return raw

    def response(self, raw: NDArray[np.uint64]) -> NDArray[np.float64]:
        """Return what the snow does to each body, (b, 42): see `neve._core.Model.solve_bodies`."""
        return summed(raw, self._deterministic).reshape(self._count, RESPONSE_NUMBERS)

    @property
    def _response_bytes(self) -> int:
        return sum_bytes(self._deterministic) * RESPONSE_NUMBERS * self._count
