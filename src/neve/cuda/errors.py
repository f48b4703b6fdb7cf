"""What can go wrong with a GPU, each in one sentence for the user."""

from __future__ import annotations


class DeviceError(RuntimeError):
    """Why a run cannot be computed on the GPU: what is missing, and what to do instead."""


class NoDevice(DeviceError):
    """Raised where there is no GPU, or no library to use it."""


class NoSuchDevice(DeviceError):
    """Raised for the number of a GPU that is not there."""

    def __init__(self, number: int, count: int) -> None:
        there = "the only GPU here is 0" if count == 1 else f"the GPUs here are 0 to {count - 1}"
        super().__init__(f"numerics.devices has GPU {number}, and {there}, as `neve info` lists them")


class DriverError(DeviceError):
    """A call of the driver library that failed, by the name of its error.

    Attributes:
        name: such as "CUDA_ERROR_OUT_OF_MEMORY"
    """

    def __init__(self, name: str) -> None:
        super().__init__(
            f"the GPU has failed ({name}): the run can be resumed from its last checkpoint, or with "
            'numerics.device = "cpu"'
        )
        self.name = name


OUT_OF_MEMORY = "CUDA_ERROR_OUT_OF_MEMORY"
"""Name of the error of an allocation that does not fit."""
