"""Known answer 24: a vertical cut stands below H_c = (4 c / rho g) tan(45 + phi / 2) and falls above it."""

import pytest

from neve.validate.grains.cut import FALLS, STANDS, critical_height, cut


def test_critical_height():
    """100 Pa at 20 degrees: M = 0.7722, phi* = 26.47, c* = 136.8 Pa, 4 c* / (rho g) tan 58.24 = 0.2252 m."""
    assert critical_height(100.0) == pytest.approx(0.2252, abs=1e-4)


@pytest.mark.parametrize(("share", "stands"), [(0.8, True), (1.3, False)])
def test_cut(share, stands):
    """The crest settles by less than 1 % of the height, or by more than 10 % in half a second.

    A free fall would take 0.29 s. Measured: 0.2 % and 22 %, both far from the bounds.
    """
    r = cut(share, cells=8)
    assert r.drop[-1] < STANDS if stands else r.drop[-1] > FALLS
