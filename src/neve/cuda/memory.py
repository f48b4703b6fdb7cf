"""Memory of the GPU that grows, and what to say when there is not enough of it."""

from __future__ import annotations

import contextlib
import weakref
from collections.abc import Callable
from typing import Any

from neve.cuda.driver import Driver
from neve.cuda.errors import OUT_OF_MEMORY, DeviceError, DriverError
from neve.system.memory import in_words

SLACK = 1.25
"""What has to grow gets so much more than it needs."""


class Buffer:
    """Memory of the GPU, given back with the object.

    Attributes:
        address; size: in bytes
    """

    def __init__(self, driver: Driver, size: int = 0) -> None:
        self._driver = driver
        self.address = self.size = 0
        self._free: Callable[[], Any] = _nothing
        if size:
            self.require(size, slack=1.0)

    def require(self, size: int, slack: float = SLACK) -> None:
        """Have room for `size` bytes; what was there is lost if there was less. Errors: DeviceError."""
        if size <= self.size:
            return
        self.release()
        for wanted in (int(size * slack), size):
            try:
                self.address, self.size = self._driver.allocate(wanted), wanted
            except DriverError as error:
                if error.name != OUT_OF_MEMORY:
                    raise
                continue
            self._free = weakref.finalize(self, _give_back, self._driver, self.address)
            return
        raise DeviceError(
            f"{self._driver.name} has {in_words(self._driver.memory()[0])} of memory left, and "
            f"{in_words(size)} more are needed: raise numerics.dx, or resume the run from its last "
            'checkpoint with numerics.device = "cpu"'
        )

    def release(self) -> None:
        """Give the memory back."""
        self._free()
        self.address = self.size = 0


def _nothing() -> None:
    return


def _give_back(driver: Driver, address: int) -> None:
    with contextlib.suppress(DriverError):  # after a kernel has failed nothing can be given back
        driver.free(address)
