"""A world of 10 km costs what the snow in it costs, and snow far from the origin moves as it does there."""

import numpy as np
import pytest

from neve import Simulation
from neve.scene.reading.load import scene_from

FIRST = 2000.0
"""So far from the origin positions of these scenes are kept to more than float32 [m]."""


def two(distance, precision, **numerics):
    """Two lumps so far from the origin [m] on both sides, falling on a plane; the first one's places."""
    lump = {"shape": "box", "size": [0.6, 0.6, 0.6]}
    tables = {
        "numerics": {"dx": 0.1, "precision": precision, "dt": 5e-4} | numerics,
        "sources": [{**lump, "center": [s * distance, 0, 0.32]} for s in (1, -1)],
        "colliders": [{"shape": "plane"}],
    }
    sim = Simulation(scene_from(tables))
    sim.advance(0.1)
    order = np.argsort(sim.state.id)
    x = places(sim)[order]
    return sim, x[: len(x) // 2] - [distance, 0, 0]


def places(sim):
    """Positions to all that there is of them, in double."""
    x = np.asarray(sim.state.x, np.float64)
    return x + sim.state.beyond if sim.state.beyond.shape[1] else x


@pytest.mark.parametrize(("precision", "rounding"), [("float64", 1e-10), ("float32", 2e-5)])
def test_only_blocks_with_snow_cost(precision, rounding):
    """At 5 km, a whole number of blocks, snow takes the blocks and bytes it takes at 2 km, and lands alike.

    A float32 at 5 km has steps of 0.5 mm; the way of 5 cm is off by less than a twentieth of one.
    """
    near, x = two(FIRST, precision)
    far, y = two(5000.0, precision)
    assert near.diagnostics().blocks == far.diagnostics().blocks
    assert near.bytes == far.bytes
    assert np.abs(y - x).max() < rounding


def adrift(distance, **numerics):
    """A ball so far from the origin along each axis [m] that drifts along x, 1 mm/s, without weight."""
    tables = {
        "world": {"gravity": [0, 0, 0]},
        "numerics": {"dx": 0.1, "dt": 1e-3} | numerics,
        "sources": [
            {"shape": "sphere", "radius": 0.3, "center": [distance] * 3, "velocity": [1e-3, 0.0, 0.0]}
        ],
    }
    return Simulation(scene_from(tables))


@pytest.mark.parametrize("transfer", ["apic", "aflip", "polypic"])
def test_snow_at_ten_kilometres_creeps(transfer):
    """1 um in a step, where a float32 has steps of 1 mm: after 50 steps all is 50 um on.

    The way in a block, below 1 m, is rounded by 2^-25 m in a step at most, 1.5 um in 50. F_E is rounded, too:
    stresses of E0 2^-24, 8 mPa, pull at 40 kg/m2 of a cell, which makes 0.25 um in 0.05 s.
    """
    sim = adrift(10_000.0, transfer=transfer)
    before = places(sim)[np.argsort(sim.state.id)]
    assert np.abs(before - 10_000.0).max() < 0.31
    sim.advance(0.05)
    moved = places(sim)[np.argsort(sim.state.id)] - before
    assert np.abs(moved - [5e-5, 0, 0]).max() < 50 * 2.0**-25 + 2.5e-7


def test_a_resumed_run_has_the_same_bits():
    """What float32 does not hold of a position is in the checkpoint."""
    sim = adrift(10_000.0)
    sim.advance(0.02)
    twin = Simulation.restore(sim.scene, sim.arrays(), threads=2)
    for run in (sim, twin):
        run.advance(0.02)
    for name, values in sim.arrays().items():
        np.testing.assert_array_equal(values, twin.arrays()[name], err_msg=name)
    assert np.abs(sim.state.beyond).max() > 1e-5


def test_solids_are_where_they_are_told():
    """A ball of snow on a shelf at 10 km, at no whole number of floats, rests as high as at the origin.

    The shelf's middle is 0.3 mm from the nearest float32.
    """
    heights = []
    for distance in (0.0, 10_000.0003):
        shelf = {"shape": "box", "size": [2, 2, 1], "center": [0, 0, distance - 0.5], "mode": "sticky"}
        tables = {
            "numerics": {"dx": 0.1, "dt": 5e-4},
            "sources": [{"shape": "sphere", "radius": 0.3, "center": [0.0, 0.0, distance + 0.32]}],
            "colliders": [shelf],
        }
        sim = Simulation(scene_from(tables))
        assert bool(sim.state.beyond.shape[1]) == (distance > 0)
        sim.advance(0.2)
        heights.append(float((places(sim)[:, 2] - distance).mean()))
    assert heights[0] < 0.31
    assert heights[1] == pytest.approx(heights[0], abs=1e-3)


def test_near_the_origin_nothing_is_added():
    """Scenes of a few hundred cells, and double precision, have the columns that they had."""
    assert adrift(5.0).state.beyond.shape == (adrift(5.0).count, 0)
    assert adrift(10_000.0, precision="float64").state.beyond.shape[1] == 0
