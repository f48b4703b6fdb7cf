"""Known answer 23: loose snow rests at its angle of friction up to 30 degrees; steeper laws fall short."""

import pytest

from neve.validate.grains.plane_strain import plane_strain, sliding
from neve.validate.grains.repose import DRAG, STEEP, repose


def test_angles_of_the_cone():
    """At 30 degrees M = 1.2: arcsin(1.2 / sqrt 3) = 43.85 in plane strain, arctan = 34.72 in steady shear."""
    assert plane_strain(30.0)[0] == pytest.approx(43.854, abs=1e-3)
    assert sliding(30.0) == pytest.approx(34.715, abs=1e-3)
    assert plane_strain(35.0)[0] == pytest.approx(54.97, abs=0.01)


@pytest.mark.parametrize("degrees", [20.0, 30.0])
def test_slope(degrees):
    """Within 3 degrees: measured 21.5 and 27.8.

    The surface is known to half a cell: over the line's 4.4 cells of height and 12 of length, 2 degrees.
    """
    r = repose(degrees, cells=8, pace=0.3)
    assert r.angle == pytest.approx(degrees, abs=3.0)
    assert r.speed < 0.02


def test_steeper_laws_fall_short():
    """A limit, not an agreement: the law of 35 degrees leaves 31 within 3, as recorded; here 29.3.

    The cone holds a face up to 55 degrees in plane strain (above); it fails at once, and the fall flattens
    the heap.
    """
    slope, scatter = STEEP[35.0]
    assert repose(35.0, cells=8, pace=0.3).angle == pytest.approx(slope, abs=scatter)
    assert slope + scatter < 35.0


def test_slow_heap_rests_at_steady_shear():
    """With a drag the same snow rests at arctan(M / sqrt 3) = 39.3 degrees; measured 36.3.

    Within 4 degrees: 3 as above, and 1 for creep and what is left of the fall, 0.5 m/s at the most.
    """
    r = repose(35.0, cells=8, pace=0.3, drag=DRAG)
    assert r.angle == pytest.approx(sliding(35.0), abs=4.0)
