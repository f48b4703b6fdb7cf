"""Twenty random scenes: no crash, nothing lost, mass exact, no energy from nowhere."""

import numpy as np
import pytest
from verification.scenes import ball, scene, simulate

from neve.diagnostics import Balance
from neve.fuzz.scenes import draw, endure
from neve.fuzz.scenes.energy import MOST_SURGE, Budget, Moment
from neve.fuzz.scenes.meters import MpmMeter, SphMeter
from neve.fuzz.scenes.situations import SITUATIONS
from neve.fuzz.scenes.trial import _fault, _mass_by_id, unclear
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.scene.values.choices import LAWS, SPLINES, TRANSFERS


@pytest.mark.filterwarnings("ignore::neve.scene.errors.SceneWarning")
@pytest.mark.parametrize("number", range(20))
def test_scene_holds(number):
    """`neve fuzz --only NUMBER` holds; the whole campaign of 200 is a command (docs/validation.md)."""
    outcome = endure(0, number)
    assert (outcome.verdict, outcome.sentence) == ("held", "")
    assert outcome.facts["steps"] > 0


def test_campaign_is_seeded_and_wide():
    """The same number is the same scene; 70 scenes take every situation, law, transfer and spline.

    A quarter is of particles in contact, a seventh of smoothed ones, but each can be drawn for any method.
    """
    drawn = [draw(7, k) for k in range(70)]
    scenes = [draw(7, k, "mpm") for k in range(70)]
    assert drawn[3] == draw(7, 3)
    assert drawn[3] != draw(8, 3)
    assert {s.numerics.method for s, _ in scenes} == {"mpm"}
    of_particles = [k for k, (s, _) in enumerate(drawn) if s.numerics.method == "particles"]
    assert 8 < len(of_particles) < 28
    for k in range(70):
        other = draw(7, k, "particles")[0]
        if drawn[k][0].numerics.method != "sph":
            assert drawn[k][0] == (other if k in of_particles else scenes[k][0])
        assert (other.snow, other.sources) == (scenes[k][0].snow, scenes[k][0].sources)
    assert {name for _, name in scenes} == set(SITUATIONS)
    for seen, count in (
        ({s.snow.law for s, _ in scenes}, len(LAWS)),
        ({s.numerics.transfer for s, _ in scenes}, len(TRANSFERS)),
        ({s.numerics.spline for s, _ in scenes}, len(SPLINES)),
        ({s.numerics.precision for s, _ in scenes}, 2),
    ):
        assert len(seen) == count


def test_refusals_are_sentences_about_the_scene():
    """What Neve says of a scene that it declines is one sentence with a key; else the trial fails."""
    with pytest.raises(SceneError) as stop:
        simulate(scene([ball(center=(0, 0, -1))], [{"shape": "plane"}]))
    assert unclear(str(stop.value), "scene") == ""
    assert unclear("fuzz scene 1/2: numerics.dx = 0 is not allowed", "fuzz scene 1/2") == ""
    for bad in ("", "it does not work", "snow.xi:\nno", "snow.xi " + 1000 * "x"):
        assert unclear(bad, "scene") != ""


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


def balances(sim, seconds):
    """Let a simulation go on, and give its budget after each step."""
    meter, budget = MpmMeter(sim), Budget(sim.scene.numerics.transfer)

    def look():
        budget.record(meter.step())
        return False

    sim.advance(seconds, look)
    return meter, budget


def test_energy_from_nowhere_is_seen():
    """At the start against all that was put in, and after dissipation against what still moves."""
    sim = simulate(scene([ball(velocity=(0, 0, -3))], [{"shape": "plane", "point": (0, 0, -0.16)}]))
    meter, budget = balances(sim, 0.001)
    assert budget.fault() == ""
    sim.state.v[:] *= 1.03  # 6 % more than was put in, but only 6 % of what moves
    for _ in range(2):
        sim.advance(0.0005)
        budget.record(meter.step())
    assert "put in" in budget.fault()
    meter, budget = balances(sim, 0.05)  # the ball is crushed and keeps a part of its energy
    assert budget.fault() == ""
    gain = budget.gain
    sim.state.v[:] *= 1.6
    for _ in range(2):
        sim.advance(0.0005)
        budget.record(meter.step())
    assert budget.gain > gain
    assert budget.surge > MOST_SURGE


@pytest.mark.parametrize("modes", [1, 8, 27])
def test_swing_of_explicit_steps_is_no_gain(modes):
    """Energy of a breathing lone particle swings by (1 + a) / (1 - a), a = w dt / 2; its shadow does not.

    APIC, quadratic, nu = 0: w^2 = 4 (3 lam + 2 mu) / (rho0 dx^2) = 4 E0 / (rho0 dx^2), so a = c dt / dx.
    At strain 1e-4 the vibration is linear to 1e-4.
    """
    table = {"transfer": "polypic", "polypic_modes": modes, "precision": "float64", "dt": 2.5e-3, "dx": 0.1}
    if modes == 1:
        table |= {"transfer": "apic"}
        del table["polypic_modes"]
    snow = {"law": "hencky", "plasticity": "none", "E0": 1e5, "nu": 0.0, "rho0": 400.0}
    speck = {"shape": "box", "size": (0.1, 0.1, 0.1), "center": (0.01, 0.03, 0.047)}
    sim = simulate(
        scene_from(
            {
                "world": {"gravity": (0, 0, 0)},
                "numerics": table | {"particles_per_cell": 1, "sampling": "regular"},
                "snow": snow,
                "sources": [speck],
                "run": {"film": False},
            }
        )
    )
    assert sim.count == 1
    sim.state.F_E[:] = 1.0001 * np.eye(3)
    meter, moments = MpmMeter(sim), []

    def look():
        moments.append(meter.step())
        return len(moments) == 200

    sim.advance(1.0, look)
    plain = [m.before.total for m in moments]
    shadow = [m.shared + m.before.elastic for m in moments]
    a = np.sqrt(1e5 / 400) * 2.5e-3 / 0.1
    assert np.ptp(shadow) < 1e-3 * shadow[0]
    assert max(plain) / min(plain) == pytest.approx((1 + a) / (1 - a), rel=0.02)
    budget = Budget()
    for moment in moments:
        budget.record(moment)
    assert budget.gain < 1e-3


@pytest.mark.parametrize(("new", "gain"), [(0.0, 0.0), (10.0, 0.1)])
def test_a_blow_is_no_gain(new, gain):
    """A plate brings snow to 50 J in one step, with work of 100 J, and then to 50 J + new out of nothing.

    The shadow energy of the step of the blow, 0 - 100 J / 2, comes back from -50 J whatever follows; of the
    plain sum, 50 J - 100 J, only what is new does.
    """

    def still(kinetic, work):
        return Balance(kinetic=kinetic, affine=0.0, elastic=0.0, potential=0.0, work=work)

    rest, hit, more = still(0.0, 0.0), still(50.0, 100.0), still(50.0 + new, 100.0)
    budget = Budget()
    for shared, before, after in ((0.0, rest, hit), (50.0 + new, hit, more), (50.0 + new, more, more)):
        budget.record(Moment(shared, before, after, 0.0))
    assert budget.gain == pytest.approx(gain)


@pytest.mark.parametrize("booked", [True, False])
def test_the_work_of_dilation_is_the_laws(booked, monkeypatch):
    """Smoothed snow that yields sideways when pressed gains energy: what its law makes, nothing more."""
    if not booked:
        monkeypatch.setattr(SphMeter, "_release", lambda *_: 0.0)
    table = {"method": "sph", "dx": 0.25, "cfl": 0.5, "strain_max": 0.1, "particles_per_cell": 4}
    block = {"shape": "box", "center": (0, 0, 0.5), "size": (1, 0.5, 0.5), "velocity": (0, 0, -2000)}
    snow = {"E0": 1e8, "nu": 0.45, "rho0": 6.0, "theta_c": 0.08, "theta_s": 0.0, "xi": 0.3}
    sim = simulate(
        scene_from(
            {
                "world": {"gravity": (0, 0, 0)},
                "numerics": table,
                "snow": snow,
                "sources": [block],
                "colliders": [{"shape": "plane", "mode": "sticky"}],
                "run": {"film": False},
            }
        )
    )
    meter, budget = SphMeter(sim), Budget()

    def look():
        budget.record(meter.step())
        return False

    sim.advance(4e-4, look)
    if booked:
        assert budget.gain < 1e-3
    else:
        assert budget.fault() != ""
