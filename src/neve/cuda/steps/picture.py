"""Positions and colours of the particles for a viewer, in 16 bits a number, of one GPU or of several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.cuda.layout import SHADES, decoded
from neve.cuda.memory import Buffer
from neve.solver import Quantised

if TYPE_CHECKING:
    from neve.cuda.model import DeviceModel
    from neve.cuda.stages import CudaStages
    from neve.cuda.state import DeviceState

MOST = 65534
"""Greatest word of a number; 65535 stands for none."""
LEAST_EXTENT = 1e-6
"""So far apart the ends of a number are taken to be at least."""


def start_ends(stages: CudaStages, model: DeviceModel, state: DeviceState, shade: str) -> None:
    """Start to look for the ends of the numbers, which become those of the grid `scratch`."""
    stages.prepare(model, state, stages.scratch, 0.0)
    stages.step.picture.shade = SHADES.index(shade)
    stages.each(model, "picture_ends", state.count)


def ends(most: NDArray[np.uint64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the least numbers and the steps, (4,) each, from what `picture_ends` has found."""
    found = decoded(most[:8]).reshape(4, 2)
    high, low = found[:, 0], -found[:, 1]
    low, high = np.where(low > high, 0.0, low), np.where(low > high, 0.0, high)  # none is finite
    return low, np.maximum(high - low, LEAST_EXTENT) / MOST


def start(
    stages: CudaStages, model: DeviceModel, state: DeviceState, low: NDArray[Any], step: NDArray[Any]
) -> Buffer:
    """Start to write the words; return where they will be."""
    words, to = Buffer(stages.driver, 8 * state.count), stages.step.picture
    to.words, to.low[:], to.per_step[:] = words.address, low.tolist(), (1.0 / step).tolist()
    stages.each(model, "draw_picture", state.count)
    return words


def read(stages: Sequence[CudaStages], words: Sequence[Buffer], counts: Sequence[int]) -> NDArray[np.uint16]:
    """Return the words of all particles, (n, 4), when they are there."""
    out = np.zeros((sum(counts), 4), np.uint16)
    first = 0
    for each, buffer, count in zip(stages, words, counts, strict=True):
        if count:
            each.driver.download(out[first:].ctypes.data, buffer.address, 8 * count)
        first += count
    return out


def quantised(words: NDArray[np.uint16], low: NDArray[Any], step: NDArray[Any], state: Any) -> Quantised:
    """Return the words with what it takes to undo them."""
    return Quantised(np.asarray(state.shown("id")), words, low, step)
