"""Who owns a block, and which blocks of nodes several domains have."""

import numpy as np
import pytest

from neve.domains.halo import CORNERS, given_by, givers_of, halos, keys_of, routes
from neve.domains.partition import Slabs, balanced
from neve.domains.transport import OneProcess


def box(*size):
    """All blocks of a box, (n, 3)."""
    return (
        np.stack(np.meshgrid(*map(np.arange, size), indexing="ij"), axis=-1).reshape(-1, 3).astype(np.int32)
    )


def covered(homes):
    """The blocks of nodes that homes cover, each once."""
    return np.unique((homes[:, None] + CORNERS).reshape(-1, 3), axis=0).astype(np.int32)


def test_owners():
    """A domain owns the blocks from its cut up to the next, without end on both sides."""
    blocks = np.array([[0, k, 0] for k in (-9, -2, -1, 0, 3, 4, 99)], np.int32)
    np.testing.assert_array_equal(Slabs(1, (-1, 4)).owner(blocks), [0, 0, 1, 1, 1, 2, 2])


@pytest.mark.parametrize("domains", [2, 3, 5])
def test_balanced_by_particles(domains):
    """Across the longest axis, with about as many particles each; a heavy layer counts for what it has."""
    blocks = np.concatenate([box(2, 30, 3), *[np.array([[0, 29, 0]], np.int32)] * 180])
    found = balanced(blocks, domains)
    assert (found.axis, found.domains) == (1, domains)
    counts = np.bincount(found.owner(blocks), minlength=domains)
    assert counts.sum() == len(blocks)
    layer = np.bincount(blocks[:, 1]).max()
    assert np.abs(counts - len(blocks) / domains).max() <= layer


def test_fewer_layers_than_domains():
    """Cuts ascend even so, and somebody owns every block."""
    for blocks in (box(1, 1, 1), box(2, 1, 1), np.zeros((0, 3), np.int32)):
        found = balanced(blocks, 4)
        assert (np.diff(found.cuts) > 0).all()
        assert len(found.cuts) == 3


class Corners(Slabs):
    """A partition by octants: up to eight domains meet at a block."""

    def owner(self, blocks):
        """Return 4 x + 2 y + z of the signs."""
        return (blocks >= 0) @ np.array([4, 2, 1])

    @property
    def domains(self):
        """Eight."""
        return 8


PARTITIONS = {"slabs": Slabs(0, (2, 3)), "octants": Corners(0, ())}


@pytest.mark.parametrize("name", list(PARTITIONS))
def test_shared_blocks(name):
    """Domains share the blocks that homes of both cover; each is counted once, and both list them alike."""
    partition = PARTITIONS[name]
    homes = box(6, 4, 3) - np.array([2, 1, 1], np.int32)
    owner = partition.owner(homes)
    rng = np.random.default_rng(1)
    blocks = {d: rng.permutation(covered(homes[owner == d])) for d in range(partition.domains)}
    found = halos(partition, OneProcess(partition.domains), blocks)
    assert sum((~halo.ghosts).sum() for halo in found.values()) == len(covered(homes))
    for d, halo in found.items():
        for e in range(partition.domains):
            both = np.intersect1d(keys_of(blocks[d]), keys_of(blocks[e])) if e != d else []
            rows = halo.shared.get(e, np.zeros(0, int))
            np.testing.assert_array_equal(keys_of(blocks[d][rows]), both)
    assert set(routes(found)) == {(d, e) for d, halo in found.items() for e in halo.shared}


@pytest.mark.parametrize("name", list(PARTITIONS))
def test_givers(name):
    """For each colour the giver of a block is the owner of the one home of that colour that covers it."""
    partition, blocks = PARTITIONS[name], box(3, 3, 3) - np.array([1, 1, 1], np.int32)
    givers = givers_of(partition, blocks)
    for block, given in zip(blocks, givers, strict=True):
        homes = (block - CORNERS).astype(np.int32)
        colours = (homes % 2) @ np.array([4, 2, 1])
        assert sorted(colours) == list(range(8))
        np.testing.assert_array_equal(given[colours], partition.owner(homes))
    halo = halos(partition, OneProcess(partition.domains), {0: blocks, 1: blocks})[0]
    if 1 in halo.shared:
        rows = halo.shared[1]
        both = np.concatenate([given_by(halo, rows, d, 5) for d in range(partition.domains)])
        np.testing.assert_array_equal(np.sort(both), np.sort(rows))


def test_sums_in_order():
    """Maxima and sums over domains, number by number; sums in the order of the domains."""
    parts = [np.array([1e16, 1.0]), np.array([1.0, 5.0]), np.array([-1e16, 2.0])]
    one = OneProcess(3)
    np.testing.assert_array_equal(one.total(parts), [(1e16 + 1.0) - 1e16, 8.0])
    np.testing.assert_array_equal(one.most(parts), [1e16, 5.0])
    np.testing.assert_array_equal(parts[0], [1e16, 1.0])  # what is given stays
