"""What the preset of smoothed particles promises, coarse and short."""

import warnings

import numpy as np

import neve
from neve.scene.errors import SceneWarning


def test_the_bridge_breaks_and_piles_up():
    """It spans the posts first, then hangs in the middle, then lies on the ground with the ball in it.

    Snow is pressed where the ball is, and the momentum of snow and ball is what gravity and posts gave.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        sim = neve.Simulation(neve.load("bridge", ["numerics.dx=0.1"]), threads=1)

    def between():
        x = np.asarray(sim.state.x)
        return x[np.abs(x[:, 0]) < 0.3, 2]

    assert between().min() > 1.0
    sim.advance(0.3)
    assert 0.4 < between().mean() < 0.95
    sim.advance(1.0)
    assert between().mean() < 0.4
    assert (np.asarray(sim.state.x)[:, 2] > 0.8).any()  # some stays on the posts
    assert np.asarray(sim.state.J_P).min() < 0.8
    ball = sim.solids()[-1][1].position
    assert ball[2] < 0.4
    assert np.asarray(sim.state.x)[:, 2].min() > -1e-3
