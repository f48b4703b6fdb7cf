"""A world of 10 km costs what the snow in it costs, and far from the origin float32 is coarser."""

import numpy as np
import pytest

from neve import Simulation
from neve.scene.reading.load import scene_from


def two(distance, precision):
    """Two lumps so far from the origin [m] on both sides, falling on a plane; the first one's places."""
    lump = {"shape": "box", "size": [0.6, 0.6, 0.6]}
    tables = {
        "numerics": {"dx": 0.1, "precision": precision, "dt": 5e-4},
        "sources": [{**lump, "center": [s * distance, 0, 0.32]} for s in (1, -1)],
        "colliders": [{"shape": "plane"}],
    }
    sim = Simulation(scene_from(tables))
    sim.advance(0.1)
    x = np.asarray(sim.state.x, np.float64)[np.argsort(sim.state.id)]
    return sim, x[: len(x) // 2] - [distance, 0, 0]


@pytest.mark.parametrize(("precision", "rounding"), [("float64", 1e-10), ("float32", 2e-3)])
def test_only_blocks_with_snow_cost(precision, rounding):
    """At 5 km, a whole number of blocks, snow takes the blocks and bytes it takes at 20 m, and lands alike.

    A float32 at 5 km has steps of 0.5 mm: the way of 5 cm is off by a few of them; a float64 by rounding.
    """
    near, x = two(20.0, precision)
    far, y = two(5000.0, precision)
    assert near.diagnostics().blocks == far.diagnostics().blocks
    assert near.bytes == far.bytes
    assert np.abs(y - x).max() < rounding
