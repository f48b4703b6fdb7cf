"""Twenty scenes of the stress campaign: no crash, nothing lost, mass exact, no energy from nowhere."""

import numpy as np
import pytest
from verification.scenes import ball, scene, simulate

from neve.stress import draw, endure
from neve.stress.campaign import MOST_GAIN, Budget, _fault, _mass_by_id
from neve.stress.draw import SITUATIONS


@pytest.mark.filterwarnings("ignore::neve.scene.errors.SceneWarning")
@pytest.mark.parametrize("number", range(20))
def test_scene_holds(number):
    """`neve stress --only NUMBER` holds; the whole campaign of 200 is a command (docs/validation.md)."""
    outcome = endure(0, number, threads=1)
    assert outcome.fault == ""
    assert outcome.steps > 0
    assert outcome.gain is None or outcome.gain <= MOST_GAIN


def test_campaign_is_seeded_and_wide():
    """The same number is the same scene; 70 scenes take every situation, law, transfer and spline."""
    scenes = [draw(7, k) for k in range(70)]
    assert scenes[3] == draw(7, 3)
    assert scenes[3] != draw(8, 3)
    assert {name for _, name in scenes} == set(SITUATIONS)
    for seen, count in (
        ({s.snow.law for s, _ in scenes}, 5),
        ({s.numerics.transfer for s, _ in scenes}, 5),
        ({s.numerics.spline for s, _ in scenes}, 2),
        ({s.numerics.precision for s, _ in scenes}, 2),
    ):
        assert len(seen) == count


def test_faults_are_seen():
    """The campaign's judge is no yes-man: NaN, a lost or doubled particle, mass and energy are told."""
    sim = simulate(scene([ball()]))
    mass, start = _mass_by_id(sim), sim.diagnostics()
    assert _fault(sim, mass) == ""
    sim.state.v[5] = (1.0, 0, 0)
    assert Budget(start).gain(sim.diagnostics()) > MOST_GAIN
    sim.state.m[3] *= 1.5
    assert "mass" in _fault(sim, mass)
    sim.state.id[4] = sim.state.id[5]
    assert "lost" in _fault(sim, mass)
    sim.state.J_P[0] = np.nan
    assert "J_P" in _fault(sim, mass)
