"""What lies flush with its walls: ponds and snow at rest, over floors, slopes, solids and terrain."""

import numpy as np
import pytest
from verification.sph.common import smoothed
from verification.sph.test_sph_water import FLOOR, SPACING, G, tank, water

from neve.validate.scenes import plane

SIZE = (0.6, 0.4, 0.3)
SLOPE = plane((0, 0, 0), tuple(np.array([-1.0, 0.0, 2.0]) / np.sqrt(5.0)), mu_c=0.0)
GROUNDS = {
    "floor": [],
    "slope": [SLOPE],
    "box": [{"shape": "box", "center": (0.1, 0, 0.07), "size": (0.23, 0.23, 0.14), "mu_c": 0.0}],
    "sphere": [{"shape": "sphere", "center": (0.1, 0, 0), "radius": 0.17, "mu_c": 0.0}],
}


def pond(ground, gravity=G, phase="water"):
    """A box that is filled to its walls, with a ground in it; what is inside that is left out."""
    content = {"shape": "box", "center": (0, 0, SIZE[2] / 2), "size": SIZE, "phase": phase, "overlap": "cut"}
    return smoothed(
        [content],
        tank(*SIZE[:2]) + ground,
        (0.0, 0.0, -gravity),
        precision="float32",
        dt_max=5e-3,
    )


def bumps(folder):
    """A hilly terrain below the pond, 0.1 m high, with walls of planes around it."""
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 61), np.linspace(-0.6, 0.6, 61))
    np.save(folder / "hills.npy", 0.05 + 0.05 * np.sin(8.0 * x) * np.cos(8.0 * y))
    return [{"shape": "terrain", "file": str(folder / "hills.npy"), "size": (1.2, 1.2), "mu_c": 0.0}]


def places(sim):
    """Where each particle is, in the order of birth."""
    return np.asarray(sim.state.x)[np.argsort(np.asarray(sim.state.id))]


@pytest.fixture(params=[*GROUNDS, "terrain"])
def ground(request, tmp_path):
    """Solids in a pond."""
    return bumps(tmp_path) if request.param == "terrain" else GROUNDS[request.param]


@pytest.mark.filterwarnings("ignore:.*starts with")
@pytest.mark.parametrize("phase", ["water", "snow"])
def test_without_gravity_nothing_moves(ground, phase):
    """Nothing is under pressure at birth, wherever its walls are: it stays, to rounding."""
    sim = pond(ground, 0.0, phase)
    start = places(sim)
    sim.advance(0.05)
    assert np.abs(places(sim) - start).max() < 1e-6


@pytest.mark.filterwarnings("ignore:.*starts with")
def test_a_pond_stays_at_rest(ground):
    """Its middle stays, to an eighth of a spacing, its energy never grows, and what moves comes to rest.

    Where a ground cuts the lattice, its lowest particles are anywhere from 0 to 1 spacing above it; those
    above a half of one leave room, in the mean over the ground the integral of u - 1/2 from 1/2 to 1, an
    eighth. On a floor alone, where the lattice fits, it is a fiftieth. What moves in the end is less than a
    two-hundredth of what it would have from falling through a spacing.
    """
    sim = pond(ground)
    before = sim.diagnostics()
    weight, start, most = before.mass * G, before.potential, -np.inf
    for _ in range(10):
        sim.advance(0.1)
        now = sim.diagnostics()
        most = max(most, now.kinetic + now.elastic + now.potential - start)
    assert most <= 0.0
    assert start - now.potential < weight * SPACING * (0.125 if ground else 0.02)
    assert now.kinetic < 0.005 * weight * SPACING


def test_water_that_was_pressed_together_stays_apart():
    """A kernel that was more than full at birth, in a corner, has lost that once it has been emptier."""
    jet = water((0, 0, 0.15), (0.3, 0.3, 0.3), velocity=(0, 0, 4))
    sim = smoothed([jet], [*tank(0.3, 0.3)[:-1], FLOOR], (0.0, 0.0, -G), precision="float32", dt_max=5e-3)
    rest = np.asarray(sim.state.rho_birth)
    assert rest.max() > 1040.0
    sim.advance(0.2)
    assert np.asarray(sim.state.rho_birth).max() < 1002.0
