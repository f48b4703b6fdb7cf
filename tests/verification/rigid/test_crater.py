"""A ball that falls on snow: denser and higher is deeper, and the work it exchanges is its energy."""

import numpy as np
import pytest

from neve.validate.rigid.crater import Fall, exponents, fall, growth, over_energy


@pytest.fixture(scope="module")
def runs():
    """Two densities from two heights, in a shallower layer."""
    return {(rho, H): fall(rho, H, layer=0.4) for rho in (600.0, 2000.0) for H in (0.1, 0.5)}


def test_monotone(runs):
    """Depth grows with density and with height.

    Twice is more than enough room for 3.3 times the mass (1.8 measured) and 3.9 times the way (1.5 measured);
    a layer that let the ball through, or a ball that floats, would not grow by a tenth.
    """
    by_density, by_height = growth(runs)
    assert by_density > 1.1
    assert by_height > 1.1


def test_energy(runs):
    """m g (H + d) is the work on the snow, as exchanged, and what little the ball kept.

    Work is counted with the velocity after a step: of n equal changes of v it misses 1 / (2 n) of the
    energy, and the first steps' changes are larger. With n > 100: 1 %.
    """
    for run in runs.values():
        assert run.steps > 100
        assert abs(run.imbalance) < 0.01
        assert run.left < 1e-3 * run.energy
        assert 0.01 < run.depth < 0.3


def test_fits_find_a_power_law():
    """Depths made from 2 rho^0.5 way^0.3 give these exponents back; so does one in the energy alone."""
    made = {}
    for rho in (100.0, 400.0, 900.0):
        for way in (0.2, 0.7):
            made[rho, way] = Fall(2 * rho**0.5 * way**0.3, way, rho * way, 0.0, 0.0, 0, 0)
    assert np.allclose(exponents(made), (0.5, 0.3), atol=1e-12)
    made = {key: Fall(3 * run.energy**0.4, run.way, run.energy, 0, 0, 0, 0) for key, run in made.items()}
    assert np.allclose(over_energy(made), (3.0, 0.4, 1.0), atol=1e-12)
