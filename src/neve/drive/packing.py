"""Lengths as the page of the car reads them from a file: numbers of 16 bits, deflated, in base64."""

from __future__ import annotations

import base64
import zlib

import numpy as np
from numpy.typing import NDArray

STEP = 1e-4
"""Step of lengths in a file, where no other is said [m]."""
LARGEST = 2**16 - 1


def steps(lengths: NDArray[np.float64], step: float = STEP) -> NDArray[np.int64]:
    """Return lengths [m] as whole steps [`step` m], none below 0 or above what 16 bits hold."""
    return np.clip(np.rint(lengths / step), 0, LARGEST).astype(np.int64)


def packed(numbers: NDArray[np.int64]) -> str:
    """Return whole numbers, modulo 2^16, as text: the lesser byte first, deflated, in base64."""
    low = (numbers % (LARGEST + 1)).astype("<u2")
    return base64.b64encode(zlib.compress(low.tobytes(), 9)).decode()
