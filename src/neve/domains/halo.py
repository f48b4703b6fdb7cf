"""The halo: blocks of nodes that several domains have, because homes on both sides of a border cover them.

A home, a block that owns particles, adds to its own nodes and to those of the seven blocks after it. So the
layer of blocks at a border is written from both sides, and the nodes there are summed over the domains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.domains.partition import Slabs
from neve.domains.transport import Route, Transport

CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)], np.int32)
"""From a home to the eight blocks of nodes that it covers, (8, 3); also the colours of homes."""

Rows = NDArray[np.int64]
_NO_KEYS = np.zeros(0, np.int64)


@dataclass(frozen=True)
class Halo:
    """What one domain shares.

    Attributes:
        shared: rows of its blocks that it has in common with each other domain; both list them alike
        ghosts: of each of its blocks, whether a domain of a lower number has it too, (n,)
        givers: of each block and colour, the domain that owns the home of that colour which covers it,
            (n, 8). Colour 4 x + 2 y + z has homes whose coordinates have the parities x, y, z; one of each
            colour covers a block.
    """

    shared: Mapping[int, Rows]
    ghosts: NDArray[np.bool_]
    givers: NDArray[np.int64]

    @property
    def union(self) -> Rows:
        """Rows of all blocks that it shares, ascending."""
        return np.unique(np.concatenate([*self.shared.values(), np.zeros(0, np.int64)]))


def halos(partition: Slabs, transport: Transport, blocks: Mapping[int, NDArray[np.int32]]) -> dict[int, Halo]:
    """Return the halo of each domain of this process, given the coordinates (n, 3) of its blocks of nodes."""
    sent: dict[Route, NDArray[np.int64]] = {}
    found = {}
    for d, mine in blocks.items():
        keys, givers = keys_of(mine), givers_of(partition, mine)
        found[d] = keys, givers
        for e in range(partition.domains):
            perhaps = np.any(givers == e, axis=1)
            if e != d and perhaps.any():
                sent[d, e] = np.sort(keys[perhaps])
    out = {}
    received = transport.swap(sent)
    for d, (keys, givers) in found.items():
        order = np.argsort(keys)
        shared = {}
        for e in range(partition.domains):
            pair = sent.get((d, e), _NO_KEYS), received.get((e, d), _NO_KEYS)
            both = np.intersect1d(*pair, assume_unique=True)
            if len(both):
                shared[e] = order[np.searchsorted(keys, both, sorter=order)]
        ghosts = np.zeros(len(keys), bool)
        for e, rows in shared.items():
            ghosts[rows] |= e < d
        out[d] = Halo(shared, ghosts, givers)
    return out


def keys_of(blocks: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return a number for each block, (n,), as `core/mpm/block_key.hpp`, given its coordinates (n, 3)."""
    x, y, z = (blocks.astype(np.int64) + (1 << 20)).T
    return np.asarray(x << 42 | y << 21 | z)


def givers_of(partition: Slabs, blocks: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return `Halo.givers` of blocks (n, 3)."""
    givers = [partition.owner(blocks - (blocks - colour & 1)) for colour in CORNERS]
    return np.stack(givers, axis=1) if len(blocks) else np.zeros((0, len(CORNERS)), np.int64)


def given_by(halo: Halo, rows: Rows, giver: int, colour: int) -> Rows:
    """Return those of `rows` whose home of a colour is owned by the domain `giver`."""
    return np.asarray(rows[halo.givers[rows, colour] == giver])


def routes(halos: Mapping[int, Halo]) -> Sequence[Route]:
    """Return who sends to whom, in order, of the domains of this process."""
    return sorted({route for d, halo in halos.items() for e in halo.shared for route in ((d, e), (e, d))})
