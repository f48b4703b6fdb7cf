"""Water that stands together is one surface."""

import numpy as np

from neve.render.pools import FEWEST, pool_of

S = 0.05  # spacing of particles [m]


def block(n):
    """The middles of n^3 cells."""
    return np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1).reshape(-1, 3).astype(np.float32) * S


def test_a_block_of_water_is_a_pool_and_lone_drops_and_slush_are_not():
    """Its surface holds what its particles do, to the width of the blur: 0.7 spacings on each side."""
    x = np.concatenate([block(12), [[2.0, 0, 0], [2.0, 1.0, 0]], block(12) + np.array([3.0, 0, 0])])
    water = np.concatenate([np.ones(12**3 + 2), np.full(12**3, 0.5)])
    inside, surface = pool_of(x, water, S)
    assert np.array_equal(np.flatnonzero(inside), np.arange(12**3))
    assert (12 * S) ** 3 < surface.volume < (13.4 * S) ** 3
    middle = 5.5 * S
    out = ((surface.vertices - middle) * surface.normals).sum(axis=1)
    assert (out > 0).all()


def test_little_water_is_drops():
    """Fewer particles than FEWEST, and as many that lie apart."""
    few = block(4)
    assert len(few) < FEWEST
    apart = block(6) * 4.0
    for x in (few, apart, few[:0]):
        inside, surface = pool_of(x, np.ones(len(x)), S)
        assert not inside.any()
        assert surface is None
