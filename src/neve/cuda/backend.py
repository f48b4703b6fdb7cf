"""The words "cuda" and "auto" of `numerics.device`."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

from neve.backend import Cpu
from neve.cuda.driver import driver
from neve.cuda.errors import NoDevice
from neve.cuda.program import compiler
from neve.cuda.several.stages import SeveralStages
from neve.cuda.stages import CudaStages
from neve.registry import FIRST

if TYPE_CHECKING:
    from neve._core import Precision


class Cuda(Cpu):
    """Run on GPUs of NVIDIA; what is not of the step runs on the processor."""

    def kernels(
        self, precision: str, deterministic: bool = False, devices: Sequence[int] = FIRST
    ) -> Precision:
        """Return the stages on the GPU, or on several. Errors: NoDevice, NoSuchDevice."""
        try:
            gpus = [driver(number) for number in devices]
            compiler(gpus[0].version)
        except NoDevice as error:
            raise NoDevice(f'numerics.device = "cuda" needs a GPU: {error}; use "cpu" or "auto"') from None
        core = super().kernels(precision)
        if len(gpus) > 1:
            return cast("Precision", SeveralStages(gpus, core, precision, deterministic))
        return cast("Precision", CudaStages(gpus[0], core, precision, deterministic))


class Auto(Cuda):
    """Run on the GPU if there is one that can be used, else on the processor."""

    def kernels(
        self, precision: str, deterministic: bool = False, devices: Sequence[int] = FIRST
    ) -> Precision:
        """Return the stages on the GPU, or those of the processor."""
        try:
            return super().kernels(precision, deterministic, devices)
        except NoDevice as error:
            logging.getLogger("neve").debug("the step runs on the processor: %s", error)
            return Cpu().kernels(precision)
