"""A driven wheel on snow: borne by it, deeper under more load; and the fit of plates it is set beside."""

import numpy as np
import pytest

from neve.validate.rigid.wheel import RADIUS, WIDTHS, Fit, Press, drive, fit, press


def test_wheel():
    """Three times the load sinks deeper; the snow bears each load and gives the pull; a pull costs slip.

    Over 0.2 s a wheel that bounces with v in its vertical motion is borne wrongly by at most m v / (0.2 s) of
    its own mass, 0.2 W / g: with v up to 0.2 m/s 2 %; 5 % is allowed, as for the push.
    """
    light, heavy = drive(2000.0, dx=0.06, seconds=0.7), drive(6000.0, 0.2, dx=0.06, seconds=0.7)
    assert heavy.sinkage > 1.3 * light.sinkage
    assert heavy.slip > light.slip + 0.02
    for run, pull in ((light, 0.0), (heavy, 0.2)):
        assert run.borne == pytest.approx(1.0, abs=0.05)
        assert run.pull == pytest.approx(pull, abs=0.05)


def test_plate():
    """A plate meets more pressure the deeper it is: three times as deep, n near 1, is more than twice."""
    plate = press(0.2, looks=12)
    first, last = np.interp([0.03, 0.09], plate.sinkage, plate.pressure)
    assert last > 2 * first > 0


def test_fit():
    """Pressures made with k_c, k_phi and n give them back, without scatter."""
    z = np.linspace(0.01, 0.1, 20)
    made = Fit(2e3, 1e5, 0.9, 0.0)
    found = fit([Press(b, z, made.pressure(b, z), 0, 0) for b in WIDTHS])
    assert np.allclose((found.k_c, found.k_phi, found.n), (2e3, 1e5, 0.9), rtol=1e-9)
    assert found.scatter < 1e-12


def test_load_of_a_wheel():
    """With n = 1 and k_c = 0 the load is k times the half segment's area; and sinkage undoes load.

    The area of the whole segment of height z: R^2 acos(1 - z / R) - (R - z) sqrt(2 R z - z^2). The mean of
    400 middles is good to 1e-5.
    """
    made, z = Fit(0.0, 3e5, 1.0, 0.0), 0.08
    area = RADIUS**2 * np.arccos(1 - z / RADIUS) - (RADIUS - z) * np.sqrt(2 * RADIUS * z - z**2)
    assert made.load(z) == pytest.approx(3e5 * area / 2, rel=1e-4)
    assert made.sinkage(made.load(z)) == pytest.approx(z, rel=1e-9)
