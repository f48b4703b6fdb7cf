"""Random scenes of particles in contact, and that their judge sees what it is there for."""

import pytest
from verification.particles.common import particles

from neve.cli import main
from neve.fuzz.scenes import endure
from neve.fuzz.scenes.judges import ParticleJudge

MORE = {"heat": {"air_temperature": 20.0, "heat_speed": 10.0}, "run": {"duration": 3e-3}}


@pytest.mark.filterwarnings("ignore::neve.scene.errors.SceneWarning")
@pytest.mark.parametrize("number", [*range(16), 50])  # 50: heat flows as the reach of lists is used up
def test_scene_holds(number):
    """`neve fuzz scenes --method particles --only NUMBER` holds."""
    outcome = endure(0, number, "particles")
    assert (outcome.verdict, outcome.sentence) == ("held", "")
    assert outcome.facts["method"] == "particles"
    assert outcome.facts["steps"] > 0


def watched():
    """Return a ball that falls on a floor, with its judge, after some steps that hold."""
    sim = particles(
        [{"shape": "sphere", "center": (0, 0, 0.16), "radius": 0.15, "velocity": (0, 0, -2)}],
        [{"shape": "plane"}],
        gravity=(0, 0, -9.81),
        more=MORE,
    )
    judge = ParticleJudge(sim)
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
    go(sim, judge, 1e-3)
    assert "energy" in judge.energy_fault()


def test_heat_from_nowhere_is_seen():
    """A joule more than air and sun gave; energy is judged while snow melts as well."""
    sim, judge = watched()
    assert judge.is_judged
    sim.state.enthalpy[0] += 1.0
    assert "heat" in judge.fault()
    sim.state.liquid[0] = 0.5
    assert judge.is_judged


def test_energy_from_nowhere_in_slush_is_seen():
    """Snow that has begun to melt is judged by its energy like any other."""
    sim, judge = watched()
    sim.state.liquid[:] = 0.5
    go(sim, judge, 2e-2)
    assert judge.energy_fault() == ""
    sim.state.v[:] *= 1.5
    go(sim, judge, 1e-3)
    assert "energy" in judge.energy_fault()


def test_other_bits_after_a_resume_are_seen():
    """A run that somebody touched after its middle is not the one that is resumed."""
    for touched in (False, True):
        sim, judge = watched()
        for part in range(3):
            go(sim, judge, MORE["run"]["duration"] / 3)
            judge.after(part, 3)
        if touched:
            sim.state.x[0, 0] += 1e-9
        assert ("resume" in judge.fault_of_end()) == touched


def test_method_is_an_option(capsys, tmp_path):
    """`--method` draws for one method; its outcomes are of no other, and what failed names it."""

    def said(*words):
        with pytest.raises(SystemExit) as stop:
            main(["fuzz", "scenes", *words])
        told = capsys.readouterr()
        return stop.value.code, told.out + told.err

    code, told = said("--method", "particle")
    assert code == 2
    assert "particles" in told
    one = ("--only", "1", "--jobs", "1", "--out")
    for method in ("particles", "mpm"):
        code, told = said(*one, str(tmp_path / method), "--method", method)
        assert code == 0
        assert f"1 by {method}" in told
    code, told = said(*one, str(tmp_path / "mpm"), "--method", "particles")
    assert code == 2
    assert "holds outcomes of neve fuzz scenes --method mpm" in told
