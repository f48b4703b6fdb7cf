"""A model on the GPU: its snows, and its solids with their samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from neve.cuda.driver import Driver, Module
from neve.cuda.layout import step_of
from neve.cuda.memory import Buffer
from neve.cuda.program import Choice, cubin

if TYPE_CHECKING:
    from neve._core import Model


class DeviceModel:
    """The core's own model, which all is asked of, and its tables on the GPU."""

    def __init__(
        self,
        driver: Driver,
        native: Model,
        precision: str,
        deterministic: bool = False,
        fused: bool = False,
    ) -> None:
        """Take over `native`; fused: let one kernel gather and scatter, where the model allows it."""
        self.native = native
        self._fused = fused
        self._driver, self._precision, self._deterministic = driver, precision, deterministic
        self._snows, self._solids = (b"", Buffer(driver)), (b"", Buffer(driver))
        self._samples: dict[int, list[Buffer]] = {}
        self._views: dict[int, Buffer] = {}
        self._modules: dict[Choice, Module] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self.native, name)

    @property
    def choice(self) -> Choice:
        """What the kernels of this model are compiled for."""
        return Choice(self._precision, *self.native.device_choice, self._deterministic, self.is_fused)

    @property
    def is_fused(self) -> bool:
        """Whether g2p2g takes the place of g2p and the next p2g.

        It has shared memory for float32 and transfers whose particles carry a matrix alone, such as APIC.
        """
        affine = not self.native.keeps_change and self.native.more_modes == 0
        return self._fused and affine and self._precision == "float32" and not self._deterministic

    @property
    def has_force(self) -> bool:
        """Whether the force comes to the nodes apart from the momentum."""
        return bool(self.native.keeps_change) or self.is_fused

    def kernels(self) -> Module:
        """Return the kernels, compiled at their first use. Errors: NoDevice, DeviceError."""
        choice = self.choice
        if choice not in self._modules:
            self._modules[choice] = self._driver.load(code_of(self._driver, choice))
        return self._modules[choice]

    def constants(self, dt: float) -> bytes:
        """Return the constants of a step of dt [s]."""
        return self.native.device_constants(dt)

    def snows(self) -> tuple[int, int]:
        """Return the address of the material table, and how many snows it has."""
        self._snows = self._current(self._snows, self.native.device_snows)
        return self._snows[1].address, self.native.snow_count

    def solids(self) -> tuple[int, int]:
        """Return the address of the solids where they are now, and how many there are."""
        count = self.native.solid_count
        if not count:
            return 0, 0
        views = [self._view(i) for i in range(count)]
        self._solids = self._current(self._solids, self.native.device_solids(views))
        return self._solids[1].address, count

    def _current(self, before: tuple[bytes, Buffer], table: bytes) -> tuple[bytes, Buffer]:
        """Return a table and where it is, copied if it has changed."""
        if table != before[0]:
            before[1].require(len(table))
            self._driver.upload(before[1].address, table, len(table))
        return table, before[1]

    def _view(self, i: int) -> int:
        """Return the address of what solid i knows of its samples; 0 for a shape with a formula."""
        if i not in self._samples:
            self._samples[i] = [self._copied(part) for part in self.native.device_samples(i)]
            if self._samples[i]:
                places = [buffer.address for buffer in self._samples[i]]
                self._views[i] = self._copied(self.native.device_view(i, places))
        return self._views[i].address if self._samples[i] else 0

    def _copied(self, part: bytes) -> Buffer:
        buffer = Buffer(self._driver, max(len(part), 1))
        self._driver.upload(buffer.address, part, len(part))
        return buffer


def code_of(driver: Driver, choice: Choice) -> bytes:
    """Return the machine code of a choice for the GPU at hand."""
    import ctypes

    size = ctypes.sizeof(step_of(choice.precision))
    return cubin(choice, driver.architecture, driver.version, size)
