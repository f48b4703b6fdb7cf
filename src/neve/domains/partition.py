"""Which domain owns a block of the grid: a static partition, as in Wang et al. 2020 on several GPUs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Slabs:
    """Divide space by planes across one axis: domain d owns the blocks from cuts[d - 1] up to cuts[d].

    axis: 0, 1 or 2; cuts: ascending coordinates of blocks, one fewer than there are domains. The first and
    the last domain have no end.
    """

    axis: int
    cuts: tuple[int, ...]

    @property
    def domains(self) -> int:
        """How many there are."""
        return len(self.cuts) + 1

    def owner(self, blocks: NDArray[np.int32]) -> NDArray[np.int64]:
        """Return the domain of each block, (n,), given its coordinates (n, 3)."""
        return np.searchsorted(np.array(self.cuts, np.int64), blocks[:, self.axis], side="right")


def balanced(blocks: NDArray[np.int32], domains: int) -> Slabs:
    """Return slabs that own about equally many particles.

    blocks: of each particle, (n, 3). They are divided across the axis along which they reach farthest. Where
    particles fill fewer layers of blocks than there are domains, some domains own none.
    """
    if not len(blocks):
        return Slabs(0, tuple(range(1, domains)))
    low, high = blocks.min(axis=0).astype(np.int64), blocks.max(axis=0).astype(np.int64)
    axis = int(np.argmax(high - low))
    before = np.concatenate([[0], np.cumsum(np.bincount(blocks[:, axis] - low[axis]))])
    cuts: list[int] = []
    for k in range(1, domains):
        nearest = int(np.argmin(np.abs(before - k * len(blocks) / domains)))
        cuts.append(max(int(low[axis]) + nearest, cuts[-1] + 1 if cuts else int(low[axis]) + 1))
    return Slabs(axis, tuple(cuts))
