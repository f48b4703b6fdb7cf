"""Known answer 16: an elastic bar vibrates at omega = (pi / 2 L) sqrt(M_c / rho) and PIC damps it."""

import pytest

from neve.validate.elastic.bar import pic_decay, vibrate
from neve.validate.scenes import transfers

WAYS = transfers()


@pytest.mark.parametrize("name", sorted(set(WAYS) - {"pic"}))
def test_period_and_energy(name, spline):
    """20 cells: period within 2 %, energy within 1 % over a period.

    The mass on the grid is lumped, which slows the mode of wave number k by the share k^2 D / 2, D = h^2 / 4
    or h^2 / 3, where a transfer smooths, and at most twice that where it does not: 0.2 %. Damping is of
    fourth order, (k h)^4 = 4e-5 a step of 200.
    """
    v = vibrate(20, 1.6, spline=spline, **WAYS[name])
    assert v.measured_period() == pytest.approx(v.period, rel=0.02)
    assert abs(v.drift()) < 0.01


@pytest.mark.parametrize(("spline", "moment"), [("quadratic", 1 / 4), ("cubic", 1 / 3)])
def test_pic_damps(spline, moment):
    """The energy left after a period is exp(-k^2 D N): known to terms of the order k^2 h^2 = 0.6 %; 3 %."""
    v = vibrate(20, 2.0, spline=spline, **WAYS["pic"])
    assert 1 + v.drift() == pytest.approx(pic_decay(v, moment), rel=0.03)
    assert v.drift() < -0.2, "PIC must damp"


def test_free_sides():
    """A slender bar with free sides: sqrt(E / rho) in place of sqrt(M_c / rho), 5 % apart; within 1 %.

    The inertia of its sideways breathing slows it by nu^2 k^2 a^2 / 12 = 3e-5 for the thickness a = 0.1 L.
    """
    v = vibrate(20, 1.6, slender=2)
    assert v.measured_period() == pytest.approx(v.period, rel=0.01)
