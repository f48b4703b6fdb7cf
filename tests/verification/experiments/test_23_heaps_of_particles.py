"""Known answers 19 and 23 for particles in contact: blocks slide as Coulomb says, heaps are steeper."""

import pytest

from neve.validate.grains.contacts import HEAPS, METHOD, SCATTER, heap
from neve.validate.grains.slide import answer, slide


def test_block_slides():
    """At 35 degrees with friction 0.5 to 1 %; measured 1.6089 for 1.6088 m/s2."""
    r = slide(35.0, 0.5, **METHOD)
    assert r.acceleration(0.5) == pytest.approx(float(answer(35.0, 0.5)), rel=0.01)


def test_heap_is_steeper_than_its_friction():
    """Particles that cannot roll rest at the recorded slope, far above friction, with fewer cells too."""
    r = heap(20.0, cells=7)
    assert r.angle == pytest.approx(HEAPS[20.0], abs=SCATTER + 2.0)
    assert r.angle > 30.0
    assert r.speed < 0.02
