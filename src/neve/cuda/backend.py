"""The words "cuda" and "auto" of `numerics.device`."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, cast

from neve.backend import Cpu
from neve.cuda.driver import driver
from neve.cuda.errors import NoDevice
from neve.cuda.program import compiler
from neve.cuda.stages import CudaStages

if TYPE_CHECKING:
    from neve._core import Precision


class Cuda(Cpu):
    """Run on the first GPU of NVIDIA; what is not of the step runs on the processor."""

    def kernels(self, precision: str, deterministic: bool = False) -> Precision:
        """Return the stages on the GPU. Errors: NoDevice."""
        try:
            gpu = driver()
            compiler(gpu.version)
        except NoDevice as error:
            raise NoDevice(f'numerics.device = "cuda" needs a GPU: {error}; use "cpu" or "auto"') from None
        return cast("Precision", CudaStages(gpu, super().kernels(precision), precision, deterministic))


class Auto(Cuda):
    """Run on the GPU if there is one that can be used, else on the processor."""

    def kernels(self, precision: str, deterministic: bool = False) -> Precision:
        """Return the stages on the GPU, or those of the processor."""
        try:
            return super().kernels(precision, deterministic)
        except NoDevice as error:
            logging.getLogger("neve").debug("the step runs on the processor: %s", error)
            return Cpu().kernels(precision)
