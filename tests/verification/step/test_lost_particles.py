"""A particle with a value that is not finite stops the run with one sentence."""

import re

import numpy as np
import pytest
from verification.scenes import ball, march, scene, simulate

from neve.solver import Blowup


def simulation(**numerics):
    return simulate(scene([ball()], **numerics))


def sentence(sim):
    with pytest.raises(Blowup) as caught:
        sim.advance(5e-4)
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 400
    return text


@pytest.mark.parametrize(("before", "initial_volume"), [(0, "grid"), (0, "sampled"), (5, "grid")])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("column", ["x", "v", "F_E", "J_P"])
def test_one_sentence(precision, column, bad, before, initial_volume):
    """It names the particle that was broken, by its id, the column, and what is allowed in it."""
    sim = simulation(precision=precision, initial_volume=initial_volume)
    if before:
        march(sim, before)
    row = 17
    victim = int(sim.state.id[row])
    getattr(sim.state, column)[row] = np.asarray(bad, precision)
    text = sentence(sim)
    assert re.search(rf"particle {victim}\b", text), text
    assert f"state.{column} = " in text
    assert "allowed is" in text


def test_beyond_the_lattice(precision):
    """A particle out of the world, whose blocks end 210 km away here, is named in a sentence too."""
    sim = simulation(precision=precision)
    march(sim, 5)
    victim = int(sim.state.id[17])
    sim.state.x[17] = [0, 0, 1e6]
    text = sentence(sim)
    assert re.search(rf"particle {victim}\b", text), text
    assert "numerics.dt" in text


def test_remedy_follows_the_time_step():
    """With an automatic time step the sentence speaks of cfl, with a fixed one of dt."""
    sim = simulation(dt="auto")
    sim.state.x[3] = [0, 0, 1e6]
    assert "numerics.cfl" in sentence(sim)


def test_a_step_too_long_is_shortened():
    """dt = 0.05 s on stiff snow that hits a floor: Neve takes shorter steps, and makes no energy of it.

    The ball brings m v^2 / 2 = 450 m [J]; afterwards there is no more than that.
    """
    sim = simulate(
        scene(
            [ball(snow={"E0": 1e7, "xi": 20.0, "theta_c": 0.02}, velocity=(0, 0, -30))],
            [{"shape": "plane", "point": (0, 0, -0.16), "normal": (0, 0, 1)}],
            dt=0.05,
            precision="float32",
        )
    )
    sim.advance(5e-3)
    now = sim.diagnostics()
    assert sim.stats.dt_mean < 1e-3
    assert now.kinetic + now.elastic < 450.0 * now.mass


def test_finite_snow_goes_on(precision, transfer):
    """The control: without a broken particle the same run does not stop."""
    sim = simulation(precision=precision, transfer=transfer)
    sim.advance(5e-4)
    assert sim.steps == 5
