"""Heat in the material point method against known answers: conduction, surfaces, phases, bits."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import erf

import neve
from neve.heat.enthalpy import C_ICE, LATENT, temperature
from neve.scene.errors import SceneWarning
from neve.scene.reading.load import scene_from

GROUND = {"shape": "plane"}


def simulate(sources, heat, colliders=(), gravity=0.0, snow=None, threads=1, **numerics):
    """Snow with heat; without flow if nothing else is said."""
    given = {"dx": 0.05, "precision": "float64"} | numerics
    described = {
        "world": {"gravity": [0, 0, gravity]},
        "numerics": given,
        "snow": snow or {"plasticity": "none"},
        "heat": heat,
        "sources": list(sources),
        "colliders": list(colliders),
    }
    return neve.Simulation(scene_from(described), threads=threads)


def passes(sim):
    """Return what lets heat flow for so long [s] while nothing moves."""
    solver = sim.solver
    solver.begin(0, 0.0)
    return lambda dt: solver.model.core.pass_heat(solver.model.native, solver.state, dt)


def celsius(sim):
    return temperature(sim.state.enthalpy[:, 0], sim.state.m)


def rod(length, dx, **more):
    """A rod of ice along x of a cell across, insulated."""
    source = {"shape": "box", "size": [length, dx, dx]}
    heat = {"air_exchange": 0.0, "conductivity": 2.0} | more
    return simulate([source], heat, dx=dx, snow={"plasticity": "none", "rho0": 917.0})


@pytest.mark.parametrize("sampling", ["regular", "jittered"])
def test_snow_conducts_as_it_should(sampling):
    """The slowest mode of a box of snow decays as Fourier's law says, to 1 %."""
    heat = {"air_exchange": 0.0, "conductivity": 1.0, "snow_temperature": -10.0}
    sim = simulate([{"shape": "box", "size": [1.2, 0.3, 0.3]}], heat, sampling=sampling)
    flow, m = passes(sim), np.asarray(sim.state.m)
    mode = np.cos(np.pi * (np.asarray(sim.state.x[:, 0]) / 1.2 + 0.5))
    sim.state.enthalpy[:, 0] = m * C_ICE * (mode - 10.0)
    t = 0.3 * 1.2**2 / (math.pi**2 / (400.0 * C_ICE))
    for _ in range(10):
        flow(t / 10)
    now = np.sum((celsius(sim) + 10.0) * mode) / np.sum(mode * mode)
    assert -math.log(now) / 0.3 == pytest.approx(1.0, abs=0.01)


def test_rod():
    """A rod whose halves have two temperatures, insulated: Fourier's cosine series, to 2 % of the difference.

    T = mean + sum over odd n of (2 dT / (n pi)) (+-1) exp(-n^2 pi^2 a t / L^2) cos(n pi x / L).
    """
    length = 3.0
    sim = rod(length, 0.05, snow_temperature=-20.0)
    flow, m, x = passes(sim), np.asarray(sim.state.m), np.asarray(sim.state.x[:, 0]) + length / 2
    sim.state.enthalpy[:, 0] = m * C_ICE * np.where(x < length / 2, -10.0, -20.0)
    before = 0.0
    for share in (0.02, 0.1, 0.3):
        t = share * length**2 / (math.pi**2 * 2.0 / (917.0 * C_ICE))
        for _ in range(20):
            flow((t - before) / 20)
        before = t
        n = np.arange(1, 400, 2)[:, None]
        series = (20.0 / (n * math.pi)) * (-1.0) ** ((n - 1) // 2)
        exact = -15.0 + np.sum(series * np.exp(-(n**2) * share) * np.cos(n * math.pi * x / length), axis=0)
        np.testing.assert_allclose(celsius(sim), exact, atol=0.2)


def test_two_snows_in_a_row():
    """What flows through two layers of different conductivity is what layers in a row let through, to 5 %.

    The ends are held at -20 and 0 deg C; the flow is 20 K / (L / 2 / k_1 + L / 2 / k_2) in the steady state.
    """
    halves = [
        {"shape": "box", "size": [0.5, 0.05, 0.05], "center": [side * 0.25, 0, 0], "snow": {"rho0": rho}}
        for side, rho in ((-1, 200.0), (1, 500.0))
    ]
    sim = simulate(halves, {"air_exchange": 0.0}, snow={"plasticity": "none"})
    flow, state = passes(sim), sim.state
    m, x = np.asarray(state.m), np.asarray(state.x[:, 0])
    k = [2.5e-6 * rho**2 - 1.23e-4 * rho + 0.024 for rho in (200.0, 500.0)]
    drop = 20.0 * (0.5 / k[0]) / (0.5 / k[0] + 0.5 / k[1])  # in the first half
    slope = np.where(x < 0, -20.0 + drop * (x + 0.5) / 0.5, -20.0 + drop + (20.0 - drop) * x / 0.5)
    state.enthalpy[:, 0] = m * C_ICE * slope
    cold, warm = x < -0.45, x > 0.45
    taken = 0.0
    for n in range(120):
        before = state.enthalpy[warm, 0].sum()
        flow(1000.0)
        if n >= 60:
            taken += before - state.enthalpy[warm, 0].sum()
        state.enthalpy[cold | warm, 0] = (m * C_ICE * slope)[cold | warm]
    exact = 20.0 * 0.0025 / (0.5 / k[0] + 0.5 / k[1]) * 60 * 1000.0
    assert taken == pytest.approx(exact, rel=0.05)


def test_stefan():
    """Water at its melting point that freezes from a cold end: Stefan's one-phase front, within 3 %.

    s = 2 l sqrt(a t), sqrt(pi) l exp(l^2) erf(l) = c dT / L, with the conductivity of the ice alone.
    """
    length, dx, cold, front_at = 1.5, 0.03, 50.0, 1.2
    sim = rod(length, dx, snow_temperature=0.0)
    flow, state = passes(sim), sim.state
    m, x = np.asarray(state.m), np.asarray(state.x[:, 0]) + length / 2
    state.enthalpy[:, 0] = m * LATENT
    end = x < dx
    ste = C_ICE * cold / LATENT
    front = brentq(lambda s: math.sqrt(math.pi) * s * math.exp(s * s) * erf(s) - ste, 1e-3, 3.0)
    t = ((front_at - dx) / (2 * front)) ** 2 / (2.0 / (917.0 * C_ICE))
    for _ in range(8000):
        state.enthalpy[end, 0] = -m[end] * C_ICE * cold
        flow(t / 8000)
    ice = 1.0 - np.clip(np.asarray(state.enthalpy[:, 0]) / (m * LATENT), 0.0, 1.0)
    assert np.sum(ice) / len(x) * length == pytest.approx(front_at, rel=0.03)


def test_surface_takes_what_it_should():
    """Ball and box take from air and sun what their surfaces do, to 10 %; none on the ground."""
    ball = {"shape": "sphere", "radius": 0.3}
    box = {"shape": "box", "size": [0.5, 0.4, 0.3], "center": [0, 0, 0.15]}
    air = {"air_exchange": 10.0, "air_temperature": 0.0, "snow_temperature": -10.0}
    sun = {"air_exchange": 0.0, "sun": 1000.0, "albedo": 0.5, "snow_temperature": -10.0}
    sides = 2 * (0.5 + 0.4) * 0.3
    for source, solids, heat, power in (
        (ball, (), air, 100.0 * 4 * math.pi * 0.09),
        (ball, (), sun, 500.0 * math.pi * 0.09),
        (box, (), air, 100.0 * (sides + 0.4)),
        (box, [GROUND], air, 100.0 * (sides + 0.2)),
    ):
        sim = simulate([source], heat, solids, dx=0.04)
        assert passes(sim)(1.0).taken == pytest.approx(power, rel=0.1)


def test_spray_has_the_surface_of_its_drops():
    """A particle alone takes what a ball of its volume takes, to 10 %."""
    heat = {"air_exchange": 10.0, "air_temperature": 0.0, "snow_temperature": -10.0}
    with pytest.warns(SceneWarning, match="cells"):
        sim = simulate([{"shape": "box", "size": [0.05] * 3}], heat, sampling="regular", particles_per_cell=8)
    flow = passes(sim)
    sim.state.x[...] += 10.0 * np.arange(sim.count)[:, None]  # far apart
    area = 4 * math.pi * (0.75 * float(sim.state.V0[0]) / math.pi) ** (2 / 3)
    assert flow(1.0).taken == pytest.approx(100.0 * area * sim.count, rel=0.1)


def test_shade():
    """A slab in the shadow of another takes nothing from the sun."""
    heat = {"air_exchange": 0.0, "sun": 1000.0, "albedo": 0.0, "snow_temperature": -10.0}
    low = {"shape": "box", "size": [0.4, 0.4, 0.1], "center": [0, 0, 0]}
    alone = simulate([low], heat)
    towards = np.array(alone.scene.light.towards_sun)
    high = {"shape": "box", "size": [1.6, 1.6, 0.1], "center": (0.6 * towards / towards[2]).tolist()}
    power = passes(alone)(1.0).taken
    both = simulate([low, high], heat)
    before = np.array(both.state.enthalpy[:, 0])[np.argsort(both.state.id)]
    passes(both)(1.0)
    gained = np.array(both.state.enthalpy[:, 0])[np.argsort(both.state.id)] - before
    assert gained[: alone.count].sum() < 0.02 * power


def test_melting_time_of_a_ball_that_recedes():
    """A ball whose water is taken away has r = R - h dT t / (rho L): it is down to a half and to an eighth of
    its mass sooner than that, by no more than 30 %, as snow that is thinned out has more surface.
    """
    R, rho = 0.3, 400.0
    heat = {"air_exchange": 15.0, "air_temperature": 10.0, "snow_temperature": 0.0}
    sim = simulate([{"shape": "sphere", "radius": R}], heat, dx=0.06)
    flow, state, passed, share = passes(sim), sim.state, 0, 1.0
    whole = float(np.sum(state.m))
    for left in (0.5, 0.125):
        while share > left:
            flow(rho * LATENT * R / (15.0 * 10.0) / 200)
            passed += 1
            liquid = np.asarray(state.enthalpy[:, 0]) / (np.asarray(state.m) * LATENT)
            share = float(np.sum(np.asarray(state.m) * np.clip(1.0 - liquid, 0.0, 1.0))) / whole
            if (liquid >= 1).any():
                state.drop(np.flatnonzero(liquid >= 1).astype(np.uint32))
                sim.solver.begin(0, 0.0)
        assert 0.7 < passed / 200 / (1.0 - left ** (1 / 3)) < 1.0


def test_melting_time_of_a_ball_that_stays():
    """A ball of snow at 0 deg C in warm air takes m L / (h A dT) as long as its surface stays: nothing moves.

    It conducts so well that no part is warmer than another, and is stopped at half of its water.
    """
    heat = {"air_exchange": 15.0, "air_temperature": 10.0, "snow_temperature": 0.0, "conductivity": 100.0}
    sim = simulate([{"shape": "sphere", "radius": 0.3}], heat, snow={"xi": 10.0}, dx=0.1)
    flow, state = passes(sim), sim.state
    m = float(np.sum(state.m))
    exact = m * LATENT / (15.0 * 10.0 * 4 * math.pi * 0.09)
    n = 0
    while sim.diagnostics().water < 0.5 * m:
        flow(exact / 200)
        n += 1
    assert n / 100 == pytest.approx(1.0, abs=0.05)


def test_closed_box_never_drifts():
    """Ten thousand passes over a cloud of all phases without air and sun: not a digit of the sum is lost."""
    sim = simulate([{"shape": "box", "size": [0.1] * 3}], {"air_exchange": 0.0, "snow_temperature": 0.0})
    flow, state = passes(sim), sim.state
    m = np.asarray(state.m)
    state.enthalpy[:, 0] = m * LATENT * np.random.default_rng(1).uniform(-0.3, 1.3, len(m))
    e = state.enthalpy[:, 0]
    scale, start, spread = np.abs(e).sum(), math.fsum(e), np.ptp(e)
    for _ in range(10_000):
        flow(2.0)
    assert math.fsum(state.enthalpy[:, 0]) == pytest.approx(start, abs=1e-12 * scale)
    assert np.ptp(state.enthalpy) < 0.9 * spread  # it did flow


def test_heat_flows_from_warm_to_cold():
    """No particle ever leaves the range of temperatures that there was."""
    sim = simulate([{"shape": "box", "size": [0.3] * 3}], {"air_exchange": 0.0})
    flow, state, rng = passes(sim), sim.state, np.random.default_rng(2)
    state.enthalpy[:, 0] = np.asarray(state.m) * C_ICE * rng.uniform(-20, -1, sim.count)
    for dt in (1.0, 100.0, 1e4, 1e6):
        low, high = celsius(sim).min(), celsius(sim).max()
        flow(dt)
        now = celsius(sim)
        assert low - 1e-9 <= now.min() <= now.max() <= high + 1e-9
    assert np.ptp(now) < 1e-2
