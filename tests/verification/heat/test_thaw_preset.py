"""What the preset `thaw` promises, coarse and with heat four times as fast."""

import warnings

import numpy as np
import pytest

import neve
from neve.scene.errors import SceneWarning


def test_a_hare_melts_in_the_sun():
    """He sinks from his ears on and becomes water, no mass is lost, and the books of heat hold."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # coarse
        sim = neve.Simulation(neve.load("thaw", ["numerics.dx=0.08", "heat.heat_speed=40000.0"]), threads=1)
    first, high = sim.diagnostics(), np.asarray(sim.state.x)[:, 2].max()
    tops, shares, energies = [high], [0.0], [first.kinetic + first.elastic + first.potential]
    for _ in range(4):
        sim.advance(0.25)
        now = sim.diagnostics()
        x, wet = np.asarray(sim.state.x), sim.columns()["phase"]()
        tops.append(x[wet < 0.5][:, 2].max(initial=0.0))
        shares.append(now.water / now.mass)
        energies.append(now.kinetic + now.elastic + now.potential)
    assert np.all(np.diff(shares) > 0)
    assert shares[-1] > 0.5
    assert tops[-1] < 0.75 * high
    assert np.all(np.diff(energies) < 0)
    assert now.mass == first.mass
    assert now.heat - first.heat == pytest.approx(now.heat_taken, rel=1e-9)
    assert sim.scene.caption == "heat x 40000 real time"
