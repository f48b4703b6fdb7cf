"""Twenty random scenes: no crash, nothing lost, mass exact, no energy from nowhere."""

import numpy as np
import pytest
from verification.scenes import ball, scene, simulate

from neve.fuzz.scenes import draw, endure
from neve.fuzz.scenes.draw import SITUATIONS
from neve.fuzz.scenes.trial import Budget, _fault, _mass_by_id
from neve.scene.values.choices import LAWS, SPLINES, TRANSFERS


@pytest.mark.filterwarnings("ignore::neve.scene.errors.SceneWarning")
@pytest.mark.parametrize("number", range(20))
def test_scene_holds(number):
    """`neve fuzz --only NUMBER` holds; the whole campaign of 200 is a command (docs/validation.md)."""
    outcome = endure(0, number)
    assert (outcome.verdict, outcome.sentence) == ("held", "")
    assert outcome.facts["steps"] > 0


def test_campaign_is_seeded_and_wide():
    """The same number is the same scene; 70 scenes take every situation, law, transfer and spline."""
    scenes = [draw(7, k) for k in range(70)]
    assert scenes[3] == draw(7, 3)
    assert scenes[3] != draw(8, 3)
    assert {name for _, name in scenes} == set(SITUATIONS)
    for seen, count in (
        ({s.snow.law for s, _ in scenes}, len(LAWS)),
        ({s.numerics.transfer for s, _ in scenes}, len(TRANSFERS)),
        ({s.numerics.spline for s, _ in scenes}, len(SPLINES)),
        ({s.numerics.precision for s, _ in scenes}, 2),
    ):
        assert len(seen) == count


def test_faults_are_seen():
    """The campaign's judge is no yes-man: NaN, a lost or doubled particle and another mass are told."""
    sim = simulate(scene([ball()]))
    mass = _mass_by_id(sim)
    assert _fault(sim, mass) == ""
    sim.state.m[3] *= 1.5
    assert "mass" in _fault(sim, mass)
    sim.state.id[4] = sim.state.id[5]
    assert "lost" in _fault(sim, mass)
    sim.state.J_P[0] = np.nan
    assert "J_P" in _fault(sim, mass)


def test_energy_from_nowhere_is_seen():
    """At the start against all that was put in, and after dissipation against what still moves."""
    sim = simulate(scene([ball(velocity=(0, 0, -3))], [{"shape": "plane", "point": (0, 0, -0.16)}]))
    budget = Budget()
    budget.record(sim.diagnostics())
    sim.state.v[:] *= 1.03  # 6 % more than was put in, but only 6 % of what moves
    budget.record(sim.diagnostics())
    assert "put in" in budget.fault()
    budget = Budget()
    budget.record(sim.diagnostics())
    sim.advance(0.05)  # the ball is crushed and keeps a part of its energy
    budget.record(sim.diagnostics())
    assert budget.fault() == ""
    sim.state.v[:] *= 1.5
    budget.record(sim.diagnostics())
    assert "between two records" in budget.fault()
