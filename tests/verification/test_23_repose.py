"""Known answer 23: loose snow comes to rest at its angle of friction."""

import pytest

from neve.validate.granular import plane_strain, sliding
from neve.validate.repose import repose


def test_angles_of_the_cone():
    """At 30 degrees M = 1.2: arcsin(1.2 / sqrt 3) = 43.85 in plane strain, arctan = 34.72 in steady shear."""
    assert plane_strain(30.0)[0] == pytest.approx(43.854, abs=1e-3)
    assert sliding(30.0) == pytest.approx(34.715, abs=1e-3)


def test_slope():
    """20 degrees, within 3.

    The surface is known to half a cell: over the line's 4.4 cells of height and 12 of length, 2 degrees.
    """
    r = repose(20.0, cells=8, pace=0.3)
    assert r.angle == pytest.approx(20.0, abs=3.0)
    assert r.speed < 0.02
