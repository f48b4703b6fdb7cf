"""Known answer 15: a column settles under its own weight, rho g H^2 / 2 M_c at the top."""

import numpy as np
import pytest

from neve.validate.elastic import settlement


def test_column(spline):
    """16 cells: stress within 2 % of the weight away from the ground; settlement within 2 % plus h / H.

    The ground holds its row of nodes and all below, so shape functions that reach across it count for too
    little: with the strain k there, the first half cell is short of the share 5/24 (quadratic) of its
    stiffness, and settles by that much of k h too far at the least; over the settlement k H / 2 this is 0.42
    h / H, and measured 0.34 (quadratic) and 0.72 (cubic, whose splines reach twice as far) at every h.
    Bound: h / H.
    """
    cells = 16
    r = settlement.settle(cells, spline=spline)
    pressure, way = settlement.answer(r.height)
    away = r.height > 3 * settlement.HEIGHT / cells
    assert np.abs(r.pressure - pressure)[away].max() < 0.02 * pressure.max()
    assert r.settlement[-1] == pytest.approx(way[-1], rel=0.02 + 1 / cells)
    assert r.settlement[-1] > way[-1]
    assert (r.sideways / r.pressure)[cells] == pytest.approx(0.25, rel=0.02)
