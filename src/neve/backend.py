"""The device seam: where the compiled stages of a solver run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from neve import _core
from neve.registry import DEVICES, FIRST

if TYPE_CHECKING:
    from neve._core import Precision

_default_threads = _core.threads()


class Backend(Protocol):
    """Give the compiled stages of a device (see `numerics.device`)."""

    def kernels(
        self, precision: str, deterministic: bool = False, devices: Sequence[int] = FIRST
    ) -> Precision:
        """Return the compiled stages for numbers of `precision`, "float32" or "float64".

        deterministic: whether runs must repeat bit for bit (see `numerics.deterministic`)
        devices: numbers of those that share the run (see `numerics.devices`)
        """
        ...

    def use_threads(self, count: int | None) -> None:
        """Run the next stages on `count` threads of the processor; None: on all."""
        ...


class Cpu:
    """Run on the processor, with vectors and threads."""

    def kernels(
        self, precision: str, deterministic: bool = False, devices: Sequence[int] = FIRST
    ) -> Precision:
        """Return the compiled stages for numbers of `precision`; they always repeat."""
        return {"float32": _core.f32, "float64": _core.f64}[precision]

    def use_threads(self, count: int | None) -> None:
        """Run the next stages on `count` threads; None: on as many as OpenMP takes by itself."""
        _core.set_threads(count or _default_threads)


def backend(device: str) -> Backend:
    """Return the backend of `device`. Errors: ValueError for a word that is not registered."""
    found: Backend = DEVICES.get(device)()
    return found
