"""Known answers 19 and 23 for particles in contact: blocks slide as Coulomb says, heaps are steeper."""

import pytest

from neve.validate.grains.contacts import METHOD, flattest, heap, steepest
from neve.validate.grains.slide import answer, slide


def test_block_slides():
    """At 35 degrees with friction 0.5 to 1 %; measured 1.6089 for 1.6088 m/s2."""
    r = slide(35.0, 0.5, **METHOD)
    assert r.acceleration(0.5) == pytest.approx(float(answer(35.0, 0.5)), rel=0.01)


def test_heap_is_steeper_than_its_friction():
    """Particles that cannot roll rest far above their angle of friction; with 10 cells at 38.5 degrees."""
    r = heap(20.0, cells=7)
    assert flattest(20.0) < r.angle < steepest(20.0)
    assert r.speed < 0.02
