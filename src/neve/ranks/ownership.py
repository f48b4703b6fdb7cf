"""Which rank owns a block: cuts of the curve through all blocks, so that ranks have about equal work."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Keys = NDArray[np.uint64]
UNEVEN = 1.1
"""The most work of a rank over the mean, from which on the cuts are chosen anew."""
HOME = 57.0
"""Work of a block beside that of its particles, as so many particles: measured, see docs/scale.md."""


def work_of(counts: NDArray[np.uint32]) -> NDArray[np.float64]:
    """Return how long blocks (n,) with so many particles each take in a step, in particles."""
    return counts.astype(np.float64) + HOME


def cuts_of(curve: Keys, work: NDArray[np.float64], ranks: int) -> Keys:
    """Return where the ranks but the first begin on the curve, (ranks - 1,), rising.

    curve: where the blocks are on it, each once, in any order, (n,); work: of each, (n,). A rank owns the
    blocks from its beginning up to that of the next one. With fewer blocks than ranks some own none.
    """
    if not len(curve):
        return np.full(ranks - 1, np.iinfo(np.uint64).max, np.uint64)
    order = np.argsort(curve)
    ends = np.cumsum(work[order])
    before = np.concatenate([[0.0], ends[:-1]])
    shares = ends[-1] * np.arange(1, ranks) / ranks
    places = np.searchsorted(before, shares)  # the first block that begins after the share
    nearer = (places > 0) & (shares - before[places - 1] < np.append(before, ends[-1])[places] - shares)
    at = np.append(curve[order], np.iinfo(np.uint64).max)
    return np.asarray(at[np.maximum(places - nearer, 0)], np.uint64)
