"""When shares of the snow are chosen anew: at the first sort after they have become too uneven."""

import types

import numpy as np
import pytest

from neve.ranks.domain import Domain
from neve.ranks.ownership import HOME, UNEVEN


class Core:
    """Stand in for the core: homes that this rank owns, with so many particles each."""

    def __init__(self, counts):
        self.counts = np.array(counts, np.uint32)

    def homes(self, grid):
        return np.arange(len(self.counts), dtype=np.uint64), self.counts

    def curve(self, keys):
        return keys

    def owners(self, homes, cuts):
        return np.zeros(len(homes), np.int32)

    def counted(self, grid):
        return 0

    def set_lightest(self, grid, lightest):
        pass


def domain_of(mine, others):
    """The first of two ranks, whose work is `mine` and that of the other `others`."""
    transport = types.SimpleNamespace(
        total=lambda found: found[0] + others, swap=lambda sent: {}
    )  # fmt: skip
    comm = types.SimpleNamespace(allgather=lambda found: [found])
    world = types.SimpleNamespace(
        rank=0, size=2, comm=comm, transport=transport,
        most=lambda found: np.maximum(found, [-np.inf, others]),
    )  # fmt: skip
    return Domain(world, Core([int(mine - HOME)]), np.array([1], np.uint64))


@pytest.mark.parametrize(("share", "anew"), [(1.0, 0), (UNEVEN - 0.01, 0), (UNEVEN + 0.01, 1), (1.9, 1)])
def test_the_bound(share, anew):
    """Below it shares stay, above it they are chosen anew, once: work over the mean of two ranks."""
    mean = 100_000.0
    domain = domain_of(round(share * mean), 2 * mean - round(share * mean))
    domain._agree(types.SimpleNamespace(count=0), None)
    domain.migrate(None, None)
    assert domain._rebalanced == anew
