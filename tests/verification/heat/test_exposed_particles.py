"""What air and sun reach of particles: boxes alone and on the ground, snow in the shade of other snow."""

import math

import pytest
from verification.particles.test_heat import GROUND, simulate

AIR = {"air_exchange": 10.0, "air_temperature": 0.0, "snow_temperature": -10.0}
SUN = {"air_exchange": 0.0, "sun": 1000.0, "albedo": 0.5, "snow_temperature": -10.0}


def taken(sim):
    """Return the heat that the snow takes from air and sun in its first moment [W]."""
    sim.solver.begin(0, 0.0)
    return sim.state.pass_heat(1.0, sim.solver.placed.native).taken


TABLE = {"shape": "box", "center": (0, 0, -0.1), "size": (2, 2, 0.2)}


@pytest.mark.parametrize("solid", [GROUND, TABLE])
def test_box_on_the_ground(solid):
    """A flat box of snow takes heat of the air by its free surface, not from what it lies on.

    To 5 % of what it takes in the air, which is what its whole surface would to 20 %.
    """
    a, h = 0.6, 0.1
    box = {"shape": "box", "center": (0, 0, h / 2), "size": (a, a, h)}
    alone, sides = taken(simulate([box], AIR, dx=0.05)), 4 * a * h
    assert alone == pytest.approx(100.0 * (2 * a * a + sides), rel=0.2)
    lying = taken(simulate([box], AIR, [solid], dx=0.05))
    assert lying == pytest.approx(alone * (a * a + sides) / (2 * a * a + sides), rel=0.05)


def test_ball_in_the_shade():
    """Of two balls one behind the other the sun reaches one, as from aside it reaches both, to 15 %."""
    across = 500.0 * math.pi * 0.2**2
    for place, count in (((0, 0, 0.8), 1), ((0.8, 0, 0), 2)):
        balls = [{"shape": "sphere", "radius": 0.2, "center": at} for at in ((0, 0, 0), place)]
        sim = simulate_lit(balls)
        assert taken(sim) == pytest.approx(count * across, rel=0.15)


def simulate_lit(balls):
    """Snow in a sun that stands above."""
    return simulate(balls, SUN, more={"light": {"sun_elevation": 90.0}})
