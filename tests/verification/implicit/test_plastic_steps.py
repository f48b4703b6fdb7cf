"""Plastic flow in the equations of an implicit step: loose snow is solved for, and ends where it should."""

import numpy as np
import pytest
from verification.scenes import ball, columns, scene, simulate

from neve.validate.grains.repose import repose

DOWN = (0.0, 0.0, -9.81)
GROUND = [{"shape": "plane", "mu_c": 0.3, "point": [0, 0, 0], "normal": [0, 0, 1]}]


def fallen(integrator, dt, seconds=0.05, law="cam_clay"):
    """Drop a ball on the ground; height of its top and width [m], and the simulation."""
    source = [ball(center=(0, 0, 0.15), velocity=(0, 0, -2))]
    how = {"integrator": integrator, "dt": dt, "implicit_strain": 1.0}
    sim = simulate(scene(source, GROUND, DOWN, snow={"law": law}, **how))
    sim.advance(seconds)
    x = columns(sim)["x"]
    return np.array([x[:, 2].max(), x[:, 0].std()]), sim


def test_a_heap_is_solved_in_long_steps():
    """Known answer 23 in steps of 10 ms, fourteen times the explicit ones: less than half of 103 are refused.

    The slope is that of explicit steps within 5 %. With the derivatives of what flows alone 89 steps more are
    needed: particles turn from flowing to not and back.
    """
    how = {"cells": 6, "pace": 0.5, "implicit_strain": 1.0}
    long = repose(20.0, integrator="implicit", dt=1e-2, **how)
    assert long.steps < 1.5 * 1.2 * 0.2 / np.tan(np.radians(25.0)) / 0.5 / 1e-2
    assert long.angle == pytest.approx(repose(20.0, integrator="explicit", **how).angle, rel=0.05)


def test_a_ball_that_crumbles_falls_as_in_explicit_steps():
    """Cam-clay that collapses: top and width within 1 % at the same dt.

    To solve for elastic snow and let it flow afterwards, as semi-implicit steps do, leaves it half as high
    again.
    """
    explicit, _ = fallen("explicit", 1e-4)
    implicit, _ = fallen("implicit", 1e-4)
    lagged, _ = fallen("semi_implicit", 1e-4)
    np.testing.assert_allclose(implicit, explicit, rtol=0.01)
    assert lagged[0] > 1.5 * explicit[0]


@pytest.mark.parametrize("law", ["stomakhin2013", "cam_clay", "drucker_prager"])
def test_newtons_method_knows_how_snow_yields(law):
    """Steps of a millisecond into the ground are solved in a few systems each, none refused."""
    _, sim = fallen("implicit", 1e-3, 0.03, law)
    assert sim.stats.rejected == 0
    assert sim.diagnostics().solve_rounds < 8
