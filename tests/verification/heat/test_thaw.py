"""What heat makes of snow of material points: melting, run-off, freezing, sintering; energy and bits."""

import numpy as np
import pytest
from verification.heat.test_grid_heat import GROUND, passes, simulate

import neve
from neve.fuzz.scenes import endure
from neve.fuzz.scenes.draw import draw
from neve.heat.enthalpy import LATENT
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.solver import Blowup

LAWS = [
    {"xi": 10.0},
    {"kind": "wet"},
    {"kind": "powder"},
    {"kind": "fresh"},
    {"law": "drucker_prager", "cohesion": 500.0},
    {"law": "neo_hookean", "plasticity": "none", "E0": 2e4},
]


def melting(threads=1, snow=None, precision="float32", numerics=None, **more):
    """A block on the ground that melts in a few seconds."""
    heat = {"air_temperature": 10.0, "sun": 800.0, "heat_speed": 20000.0} | more
    block = {"shape": "box", "size": [0.2, 0.2, 0.25], "center": [0, 0, 0.125]}
    return simulate(
        [block], heat, [GROUND], -9.81, snow or {"kind": "wet"}, threads=threads, dx=0.05,
        precision=precision, **(numerics or {}),
    )  # fmt: skip


def energy(sim):
    """Mechanical energy, and its kinetic part [J]."""
    t = sim.diagnostics()
    return t.kinetic + t.affine + t.elastic + t.potential, t.kinetic + t.affine


def test_balance_and_run_off():
    """While a block melts and runs off, heat is what air and sun gave, to rounding."""
    sim = melting(heat_speed=40000.0)
    start, width = sim.diagnostics(), np.ptp(np.asarray(sim.state.x)[:, 0])
    sim.advance(2.5)
    now = sim.diagnostics()
    assert now.water > 0.5 * now.mass
    assert now.heat - start.heat == pytest.approx(now.heat_taken, rel=1e-12)
    water = np.asarray(sim.state.thermal[:, 0]) >= 1
    assert np.ptp(np.asarray(sim.state.x)[water, 0]) > 2 * width
    assert now.mass == start.mass


@pytest.mark.parametrize("snow", LAWS, ids=lambda snow: next(iter(snow.values())))
def test_melting_makes_no_energy(snow):
    """Snow of any law under its own weight: no pass that melts it adds elastic energy, and no motion follows
    but by gravity: mechanical energy only falls, to the rounding of sums in double.
    """
    sim = melting(snow=snow, precision="float64", air_temperature=30.0)
    sim.advance(0.2)
    before, _ = energy(sim)
    for _ in range(12):
        sim.advance(0.1)
        now, _ = energy(sim)
        assert now <= before + 1e-12 * abs(before)
        before = now
    assert sim.diagnostics().water > 0.1 * sim.diagnostics().mass


@pytest.mark.parametrize("snow", LAWS, ids=lambda snow: next(iter(snow.values())))
def test_melting_without_gravity_moves_nothing(snow):
    """Snow at rest without stress, with pores, stays where it is when it melts and when it freezes again."""
    sim = simulate([{"shape": "box", "size": [0.3] * 3}], {"air_exchange": 0.0}, snow=snow, dx=0.05)
    for share in (0.5, 1.2, 0.5, -0.1):
        sim.state.enthalpy[:, 0] = np.asarray(sim.state.m) * LATENT * share
        for _ in range(6):
            sim.advance(0.1)
            assert energy(sim)[1] <= 1e-20


def column(share, snow, height=0.2, **numerics):
    """A column in a tight box, of which `share` has melted."""
    walls = [
        {"shape": "plane", "point": [side * 0.1 * (axis == 0), side * 0.1 * (axis == 1), 0],
         "normal": [-side * (axis == 0), -side * (axis == 1), 0], "mode": "slip"}
        for axis in (0, 1) for side in (-1, 1)
    ]  # fmt: skip
    block = {"shape": "box", "size": [0.2, 0.2, height], "center": [0, 0, height / 2]}
    sim = simulate(
        [block], {"air_exchange": 0.0, "snow_temperature": 0.0}, [*walls, GROUND], -9.81, snow, **numerics
    )
    sim.state.enthalpy[:, 0] = np.asarray(sim.state.m) * LATENT * share
    return sim


@pytest.mark.parametrize("snow", LAWS[:2], ids=lambda snow: next(iter(snow.values())))
def test_water_lies_level_as_dense_as_ice(snow):
    """Snow that has melted in a box sinks to the height that its mass has at 917 kg/m3, to a cell.

    Freezing keeps it there, without a gain of energy.
    """
    sim = column(1.0, snow, 0.3)
    state, rho = sim.state, float(sim.state.m[0] / sim.state.V0[0])
    sim.advance(1.5)
    assert 2 * np.asarray(state.x)[:, 2].mean() == pytest.approx(0.3 * rho / 917.0, abs=0.05)
    assert np.median(state.m / (state.V0 * state.J_P)) == pytest.approx(917.0, rel=0.05)
    assert np.all(np.asarray(state.F_E) == np.eye(3))
    before, height = energy(sim)[0], np.asarray(state.x)[:, 2].mean()
    state.enthalpy[:, 0] = -1e-3 * LATENT * np.asarray(state.m)
    for _ in range(5):
        sim.advance(0.1)
        now = energy(sim)[0]
        assert now <= before + 1e-4 * abs(before)
        before = now
    assert np.all(np.asarray(state.thermal[:, 0]) == 0)
    assert np.asarray(state.x)[:, 2].mean() == pytest.approx(height, rel=0.03)
    J = np.asarray(state.J_P) * np.linalg.det(np.asarray(state.F_E))
    assert np.median(state.m / (state.V0 * J)) == pytest.approx(917.0, rel=0.05)


@pytest.mark.parametrize("snow", LAWS, ids=lambda snow: next(iter(snow.values())))
def test_no_phase_change_gives_elastic_energy(snow):
    """Heat that comes and goes at random over pressed and stretched snow never raises its elastic energy."""
    rng = np.random.default_rng(4)
    sim = simulate([{"shape": "box", "size": [0.3] * 3}], {"air_exchange": 0.0}, snow=snow, dx=0.1)
    flow, state = passes(sim), sim.state
    state.F_E[...] = np.eye(3) + rng.uniform(-0.02, 0.02, (sim.count, 3, 3))
    state.J_P[...] = 1.0 if "plasticity" in snow else rng.uniform(0.5, 1.2, sim.count)
    if "plasticity" not in snow and snow.get("law", snow.get("kind")) in ("drucker_prager", "powder"):
        state.J_P[...] = rng.uniform(1.0, 1.2, sim.count)
    core, native = sim.solver.model.core, sim.solver.model.native
    for _ in range(40):
        before = core.totals(native, state).elastic
        state.enthalpy[:, 0] = np.asarray(state.m) * LATENT * rng.uniform(-0.5, 1.5, sim.count)
        assert flow(1e-9).changed
        assert core.totals(native, state).elastic <= before * (1 + 1e-9) + 1e-12


def hangs(load, rest):
    """How high a slab is after 0.4 s under `load` times its weight, if it has sintered for `rest` [s]."""
    posts = [
        {"shape": "box", "size": [0.1, 0.4, 0.1], "center": [x, 0, -0.15], "mode": "sticky"}
        for x in (-0.3, 0.3)
    ]
    slab = {"shape": "box", "size": [0.7, 0.1, 0.2], "center": [0, 0, 0]}
    heat = {"air_exchange": 0.0, "snow_temperature": -2.0, "sintering": True}
    snow = {"kind": "fresh"}
    sim = simulate([slab], heat, posts, 0.0, snow, dx=0.05)
    if rest:
        passes(sim)(rest)
    sim.change(
        sim.scene.model_copy(
            update={"world": sim.scene.world.model_copy(update={"gravity": (0.0, 0.0, -9.81 * load)})}
        )
    )
    sim.advance(0.4)
    x = np.asarray(sim.state.x)
    middle = np.abs(x[:, 0]) < 0.1
    return x[middle, 2].mean()


def test_sintered_slab_bears_more():
    """A slab across two posts bears twice its weight after an hour of rest; a fresh one falls."""
    assert hangs(2.0, 0.0) < -0.3
    assert hangs(2.0, 3600.0) > -0.03


def test_sintering():
    """Strength at rest grows as the 0.21th power of time, slower in the cold, up to what the law bears."""
    for celsius, law in ((-5.0, {"kind": "fresh"}), (-30.0, {"kind": "fresh"})):
        heat = {"air_exchange": 0.0, "snow_temperature": celsius, "sintering": True, "conductivity": 1e-3}
        sim = simulate([{"shape": "box", "size": [0.2] * 3}], heat, snow=law)
        flow = passes(sim)
        pace = np.exp(-5.86e4 / 8.314 * (1 / (273.15 + celsius) - 1 / 268.15))
        flow(100.0)
        np.testing.assert_allclose(sim.state.thermal[:, 1], (1 + 100.0 * pace) ** 0.21, rtol=1e-9)
        flow(1e7)
        most = 0.1 * 2e5 / (3 * (1 - 0.4)) / 1200.0  # a tenth of the bulk modulus over p0
        np.testing.assert_allclose(sim.state.thermal[:, 1], min(most, (917.0 / 150.0) ** 2.44), rtol=1e-9)
        sim.advance(0.02)
        assert float(np.asarray(sim.state.thermal[:, 1]).min()) > 9.0
    moving = simulate([{"shape": "box", "size": [0.2] * 3, "spin": [0, 0, 0]}], heat, snow=law)
    moving.state.v[:, 0] = 0.5 * np.asarray(moving.state.x[:, 1])  # sheared at |sym grad v| = 0.35 / s
    passes(moving)(1e4)
    assert np.all(np.asarray(moving.state.thermal[:, 1]) == 1)


def test_same_bits():
    """Threads and a resume in the middle of a thaw change no bit."""
    sims = [melting(threads, sintering=True) for threads in (1, 2, 1)]
    for sim in sims:
        sim.advance(0.323)
    sims[2] = neve.Simulation.restore(sims[2].scene, sims[2].arrays(), threads=3)
    for sim in sims:
        sim.advance(0.3)
    arrays = [sim.arrays() for sim in sims]
    for name, value in arrays[0].items():
        for other in arrays[1:]:
            np.testing.assert_array_equal(value, other[name], err_msg=name)
    assert sims[0].diagnostics() == sims[1].diagnostics()
    assert (np.asarray(sims[0].state.thermal[:, 0]) >= 1).any()


def test_sleepers_wake_when_they_melt():
    """Snow that sleeps takes heat as well, and wakes when its phase changes."""
    sleepy = {"sleep": True, "sleep_speed": 0.02, "sleep_after": 0.1}
    sim = melting(heat_speed=1.0, snow={"E0": 1e6}, numerics=sleepy)
    for _ in range(20):
        sim.advance(0.05)
    assert sim.diagnostics().asleep == sim.state.count
    warmer = sim.scene.model_copy(update={"heat": sim.scene.heat.model_copy(update={"heat_speed": 40000.0})})
    sim.change(warmer)
    sim.advance(1.5)
    assert sim.diagnostics().asleep == 0
    assert sim.diagnostics().water > 0.3 * sim.diagnostics().mass


def test_snow_that_comes_has_heat():
    """Snow out of an emitter has the temperature of snow at birth; `heat` is that of all snow there is."""
    emitter = {
        "shape": "box",
        "size": [0.2, 0.2, 0.1],
        "center": [0, 0, 1],
        "velocity": [0, 0, -1],
        "end": 0.2,
    }
    scene = scene_from(
        {
            "numerics": {"dx": 0.05},
            "heat": {"air_exchange": 0.0, "snow_temperature": -5.0},
            "emitters": [emitter],
        }
    )
    sim = neve.Simulation(scene, threads=1)
    sim.advance(0.3)
    now = sim.diagnostics()
    assert now.mass > 0
    assert now.heat == pytest.approx(-5.0 * 2100.0 * now.mass, rel=1e-6)


def test_refusals():
    """One sentence each: no GPU, a wrong state."""
    with pytest.raises(SceneError, match=r'heat: numerics\.device = "cuda" knows no heat; use "cpu"'):
        melting(numerics={"device": "cuda"})
    sim = melting()
    sim.state.thermal[3, 0] = 2.0
    with pytest.raises(Blowup, match=r"state\.thermal"):
        sim.advance(0.01)


def test_columns():
    """What film, viewer and exports draw: temperature and phase, and the log's sums."""
    sim = melting(snow_temperature=-3.0)
    columns = sim.columns()
    np.testing.assert_allclose(columns["temperature"](), -3.0, rtol=1e-6)
    assert np.all(columns["phase"]() == 0)
    assert not {"enthalpy", "thermal", "rest"} & set(columns)
    assert sim.diagnostics().heat_speed == 20000.0
    assert sim.scene.caption == "heat x 20000 real time"


def test_random_scenes_with_heat_hold():
    """`neve fuzz scenes --method mpm`: the first that is drawn with heat holds, heat and energy judged."""
    number = next(n for n in range(40) if draw(0, n, "mpm")[0].heat is not None)
    outcome = endure(0, number, "mpm")
    assert (outcome.verdict, outcome.sentence) == ("held", "")
    assert "heat x" in outcome.about


def test_heat_sleep_and_resume_at_once():
    """Snow falls asleep in heat and wakes as it melts: resumed in sleep and after it, the same bits."""

    def ended(resumes):
        sim = melting(
            heat_speed=1.0,
            snow={"E0": 1e6},
            numerics={"sleep": True, "sleep_speed": 0.02, "sleep_after": 0.1},
        )
        slept = []
        for part in range(8):
            sim.advance(0.2)
            slept.append(int(sim.diagnostics().asleep))
            if part in resumes:
                sim = neve.Simulation.restore(sim.scene, sim.arrays(), threads=2)
            if part == 5:
                hot = sim.scene.heat.model_copy(update={"heat_speed": 40000.0})
                sim.change(sim.scene.model_copy(update={"heat": hot}))
        return sim, slept

    whole, slept = ended(())
    assert slept[5] > 0.5 * whole.count
    assert slept[7] < slept[5]
    assert whole.diagnostics().water > 0
    stopped = ended((5, 6))[0].arrays()
    for name, values in whole.arrays().items():
        np.testing.assert_array_equal(values, stopped[name], err_msg=name)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_water_is_pressed_by_its_equation_of_state(share):
    """Pressed to nine tenths, where ice's 8.9 GPa do not begin yet: stress, energy and wave speed of J.

    With r = J_i / J and A = f J_i K they are A (r^7 - 1) / 7, its integral over ln r, and that by which
    A r^7 V0 / m is the square of a speed.
    """
    block = {"shape": "box", "size": [0.2] * 3}
    sim = simulate([block], {"air_exchange": 0.0}, snow={"E0": 2e5}, dx=0.05, precision="float64")
    state, flow = sim.state, passes(sim)
    state.enthalpy[:, 0] = np.asarray(state.m) * LATENT * share
    flow(1e-9)
    core, native = sim.solver.model.core, sim.solver.model.native
    m, V0, K = float(state.m[0]), float(state.V0[0]), sim.scene.snow.E0 / (3 * (1 - 2 * sim.scene.snow.nu))
    full = m / (917.0 * V0)
    for r in (1.0, 1 / 0.95, 1 / 0.905):
        state.J_P[...] = full / r  # F_E is 1: the skeleton bears nothing
        wave = core.refresh(native, state).wave
        A = share * full * K
        np.testing.assert_allclose(state.tau[:, 0], -A * (r**7 - 1) / 7, rtol=1e-9, atol=1e-9)
        elastic = A * ((r**7 - 1) / 7 - np.log(r)) / 7 * V0 * sim.count
        assert core.totals(native, state).elastic == pytest.approx(elastic, rel=1e-6, abs=1e-12)
        assert share < 1 or wave**2 == pytest.approx(A * r**7 * V0 / m, rel=1e-9)
