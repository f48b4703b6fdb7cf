"""Random scenes of smoothed particles, and that their judge sees what it is there for."""

import numpy as np
import pytest
from verification.sph.common import smoothed

from neve.fuzz.scenes import draw, endure
from neve.fuzz.scenes.draw import SMOOTHED_PER_CELL
from neve.fuzz.scenes.judges import SphJudge, depths

DURATION = 0.03


@pytest.mark.filterwarnings("ignore::neve.scene.errors.SceneWarning")
@pytest.mark.parametrize("number", [2, 3, 4, 5, 7, 10])
def test_scene_holds(number):
    """`neve fuzz scenes --method sph --only NUMBER` holds."""
    outcome = endure(0, number, "sph")
    assert (outcome.verdict, outcome.sentence) == ("held", "")
    assert outcome.facts["method"] == "sph"
    assert outcome.facts["steps"] >= 30


def test_campaigns_have_them():
    """A campaign of any method draws some; their cells hold few particles, and their clock runs longer."""
    drawn = [draw(7, k)[0] for k in range(70)]
    found = [k for k, scene in enumerate(drawn) if scene.numerics.method == "sph"]
    assert 3 < len(found) < 20
    for k in found:
        other = draw(7, k, "mpm")[0]
        assert drawn[k] == draw(7, k, "sph")[0]
        assert drawn[k].snow == other.snow
        assert drawn[k].numerics.particles_per_cell <= SMOOTHED_PER_CELL
        assert drawn[k].run.duration > 2 * other.run.duration or drawn[k].run.duration == 86400


def watched():
    """Return a ball that falls on a floor, with its judge, after some steps that hold."""
    sim = smoothed(
        [{"shape": "sphere", "center": (0, 0, 0.16), "radius": 0.15, "velocity": (0, 0, -2)}],
        [{"shape": "plane"}],
        gravity=(0, 0, -9.81),
        dt_max=2e-3,
    )
    sim.scene = sim.scene.model_copy(update={"run": sim.scene.run.model_copy(update={"duration": DURATION})})
    judge = SphJudge(sim)
    judge.begin()
    go(sim, judge, 0.02)
    assert (judge.energy_fault(), judge.fault()) == ("", "")
    return sim, judge


def go(sim, judge, seconds):
    def look():
        judge.record()
        return False

    sim.advance(seconds, look)


def test_energy_and_momentum_from_nowhere_are_seen():
    """A push that nothing accounts for is told, a blow through the floor as well."""
    sim, judge = watched()
    sim.state.v[:, 0] += 1e-6
    assert "momentum" in judge.fault()
    sim, judge = watched()
    sim.state.v[:] *= 1.3
    go(sim, judge, 5e-3)
    assert "energy" in judge.energy_fault()


def test_a_particle_in_a_solid_is_seen():
    """One that is most of a particle spacing below the floor."""
    sim, judge = watched()
    sim.state.x[np.argmin(sim.state.x[:, 2]), 2] = -0.8 * sim.scene.numerics.spacing
    assert "0.8 distances of particles deep in solid 0" in judge.fault()


def test_a_particle_between_solids_that_overlap_is_in_neither():
    """Deep in one that stands free it counts as it is; in two at once not, and less near the other."""
    phi, other = np.array([-0.3, -0.3, -0.3, 0.2]), np.array([[0.4, -0.1, 0.2, 0.2]])
    np.testing.assert_allclose(depths(phi, other), [0.3, 0.0, 0.2, -0.2])
    np.testing.assert_allclose(depths(phi, other[:0]), [0.3, 0.3, 0.3, -0.2])


def test_a_third_have_water():
    """What is of snow alone is left out of them: they are legal."""
    wet = [k for k in range(30) if any(s.is_water for s in draw(11, k, "sph")[0].sources)]
    assert 5 <= len(wet) <= 16


def test_other_bits_after_a_resume_are_seen():
    """A run that somebody touched after its middle is not the one that is resumed."""
    for touched in (False, True):
        sim, judge = watched()
        for part in range(3):
            go(sim, judge, DURATION / 3)
            judge.after(part, 3)
        if touched:
            sim.state.x[0, 0] += 1e-9
        assert ("resume" in judge.fault_of_end()) == touched
