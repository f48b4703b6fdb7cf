"""Snow on a tree drops when the tree is hit, and stays while it is not: the preset pine, coarse."""

import numpy as np
import pytest

import neve
from neve.scene.reading.load import load

COARSE = (
    "numerics.dx=0.08",
    "sources.0.size=[1.6, 1.5]",
    "sources.0.tolerance=0.05",
    "sources.0.steps=2",
    "colliders.1.radius=0.09",
)


def places(run):
    """Where the particles are, in the order of birth."""
    return np.asarray(run.state.x)[np.argsort(np.asarray(run.state.id))].copy()


@pytest.mark.parametrize(("changes", "drops"), [((), True), (("bodies.1.velocity=[-20, 0, 0]",), False)])
def test_a_hit_tree_drops_its_snow(changes, drops):
    """Half a second after the hit a third of the snow on the branches is 0.15 m lower; else it stays."""
    run = neve.Simulation(load("pine", (*COARSE, *changes)))
    before = places(run)
    high = before[:, 2] > 0.7
    assert high.sum() > 300
    run.advance(0.5)
    lower = (before - places(run))[high, 2] > 0.15
    assert lower.mean() > 0.33 if drops else lower.mean() < 0.05
