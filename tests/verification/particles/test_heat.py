"""Heat of particles against known answers: balance, Fourier's series, Stefan's front, melting, bits."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import erf

import neve
from neve.heat.enthalpy import C_ICE, LATENT, temperature
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import scene_from
from neve.solver import Blowup

AREA_OF_BOND = 0.79
"""Area of a bond over pi r^2, as docs/heat.md says."""
GROUND = {"shape": "plane"}


def simulate(sources, heat, colliders=(), gravity=0.0, snow=None, threads=1, more=None, **numerics):
    """Snow with heat; without bonds that break if nothing else is said. more: further tables of the scene."""
    given = {"method": "particles", "dx": 0.05, "precision": "float64"} | numerics
    described = {
        "world": {"gravity": [0, 0, gravity]},
        "numerics": given,
        "snow": snow or {"plasticity": "none"},
        "heat": heat,
        "sources": list(sources),
        "colliders": list(colliders),
    } | (more or {})
    return neve.Simulation(scene_from(described), threads=threads)


@pytest.fixture
def rod():
    """Make a chain of 61 single particles along x, whose bonds have a known area; return it in order of x."""

    def make(**heat):
        source = {"shape": "box", "size": [61 * 0.05, 0.05, 0.05]}
        with pytest.warns(SceneWarning, match="cells"):
            sim = simulate(
                [source], {"air_exchange": 0.0, "conductivity": 2.0} | heat, sampling="regular",
                particles_per_cell=1, snow={"plasticity": "none", "rho0": 917.0},
            )  # fmt: skip
        sim.solver.begin(0, 0.0)
        return sim, np.argsort(np.asarray(sim.state.x[:, 0]))

    return make


def conductivity_of_chain(sim, k, a):
    """Return what a chain of particles that are `a` [m] apart conducts, if snow conducts k [W/(m K)]."""
    return k * AREA_OF_BOND * math.pi * float(sim.state.radius[0]) ** 2 / a**2


def test_rod(rod):
    """A rod whose halves have two temperatures, insulated: Fourier's cosine series, to 1 % of the difference.

    T = mean + sum over odd n of (2 dT / (n pi)) (+-1) exp(-n^2 pi^2 a t / L^2) cos(n pi x / L); the chain's
    own error is (pi n / 61)^2 / 12 of the rate of mode n.
    """
    sim, _ = rod(snow_temperature=-20.0)
    state, m, a, length = sim.state, float(sim.state.m[0]), 0.05, 61 * 0.05
    x = np.asarray(state.x[:, 0]) + length / 2
    state.enthalpy[...] = (
        m * C_ICE * np.where(x < length / 2, -10.0, np.where(x > length / 2 + 1e-6, -20, -15))
    )
    diffusivity = conductivity_of_chain(sim, 2.0, a) / (917.0 * C_ICE)
    before = 0.0
    for share in (0.02, 0.1, 0.3):
        t = share * length**2 / (math.pi**2 * diffusivity)
        for _ in range(50):
            state.pass_heat((t - before) / 50)
        before = t
        n = np.arange(1, 400, 2)[:, None]
        series = (20.0 / (n * math.pi)) * (-1.0) ** ((n - 1) // 2)
        exact = -15.0 + np.sum(series * np.exp(-(n**2) * share) * np.cos(n * math.pi * x / length), axis=0)
        np.testing.assert_allclose(temperature(state.enthalpy, state.m), exact, atol=0.1)


def test_packed_snow_conducts_as_it_should():
    """A box of packed snow: its slowest mode decays as with the given conductivity, to 6 %."""
    heat = {"air_exchange": 0.0, "conductivity": 1.0, "snow_temperature": -10.0}
    sim = simulate([{"shape": "box", "size": [0.6, 0.3, 0.3]}], heat)
    sim.solver.begin(0, 0.0)
    state, m = sim.state, np.asarray(sim.state.m)
    mode = np.cos(np.pi * (np.asarray(state.x[:, 0]) / 0.6 + 0.5))
    state.enthalpy[...] = m * C_ICE * (mode - 10.0)
    t = 0.3 * 0.6**2 / (math.pi**2 / (400.0 * C_ICE))
    for _ in range(10):
        state.pass_heat(t / 10)
    now = np.sum((temperature(state.enthalpy, m) + 10.0) * mode) / np.sum(mode * mode)
    assert -math.log(now) / 0.3 == pytest.approx(1.0, abs=0.06)


def test_stefan(rod):
    """Water at its melting point that freezes from a cold end: Stefan's one-phase front, within 3 %.

    s = 2 l sqrt(a t), sqrt(pi) l exp(l^2) erf(l) = c dT / L, with the conductivity of the ice alone.
    """
    sim, order = rod(snow_temperature=0.0)
    state, m, a, cold = sim.state, float(sim.state.m[0]), 0.05, 50.0
    state.enthalpy[...] = m * LATENT
    state.pass_heat(1e-6)
    assert np.all(np.asarray(state.liquid) == 1.0)
    assert sim.diagnostics().bonds == 0
    ste = C_ICE * cold / LATENT
    front = brentq(lambda s: math.sqrt(math.pi) * s * math.exp(s * s) * erf(s) - ste, 1e-3, 3.0)
    radius = (0.55 * 0.75 / math.pi) ** (1 / 3) * a  # of ice
    k = 2.0 * AREA_OF_BOND * math.pi * radius**2 / a**2
    t = (40 * a / (2 * front)) ** 2 / (k / (917.0 * C_ICE))
    for _ in range(2000):
        state.enthalpy[order[0]] = -m * C_ICE * cold
        state.pass_heat(t / 2000)
    water = np.clip(np.asarray(state.enthalpy)[order] / (m * LATENT), 0.0, 1.0)
    assert (np.sum(1.0 - water[1:]) + 0.5) * a == pytest.approx(40 * a, rel=0.03)
    assert sim.diagnostics().bonds == pytest.approx(39, abs=2)  # what freezes is bonded


@pytest.mark.parametrize("left", [0.5, 0.25, 0.125])
def test_melting_time_of_a_ball_that_recedes(left):
    """A ball of 900 particles whose water is taken away has r = R - h dT t / (rho L): its mass is down to the
    share `left` after rho L R (1 - left^(1/3)) / (h dT), to 15 %, as exposed area is known.
    """
    R, rho = 0.3, 400.0
    heat = {"air_exchange": 15.0, "air_temperature": 10.0, "snow_temperature": 0.0}
    sim = simulate([{"shape": "sphere", "radius": R}], heat, dx=0.1)
    solver, whole, passed, share = sim.solver, float(np.sum(sim.state.m)), 0, 1.0
    assert 850 < sim.state.count < 1000
    assert whole == pytest.approx(rho * 4 / 3 * math.pi * R**3, rel=0.01)
    solver.begin(0, 0.0)
    while share > left:
        solver.state.pass_heat(rho * LATENT * R / (15.0 * 10.0) / 200)
        passed += 1
        liquid = np.asarray(solver.state.liquid)
        share = float(np.sum(np.asarray(solver.state.m) * (1.0 - liquid))) / whole
        if (liquid >= 1).any():  # the water
            kept = np.flatnonzero(liquid < 1).astype(np.uint32)
            solver._settle(solver.state.with_particles(kept, 0), None)
    assert passed / 200 == pytest.approx(1.0 - left ** (1 / 3), rel=0.15)


def test_melting_time_of_one_particle():
    """A particle alone in warm air takes m L from its surface, which shrinks with the volume ratio J.

    m L df = h 4 pi r^2 J^(2/3) dT dt with J = 1 - f (1 - J_w), J_w = 400 / 1000.
    """
    with pytest.warns(SceneWarning, match="cells"):
        sim = simulate(
            [{"shape": "box", "size": [0.05] * 3}],
            {"air_exchange": 15.0, "air_temperature": 10.0, "snow_temperature": 0.0},
            sampling="regular", particles_per_cell=1,
        )  # fmt: skip
    sim.solver.begin(0, 0.0)
    state, J_w = sim.state, 0.4
    m, V = float(state.m[0]), float(state.V0[0])
    area = 4 * math.pi * (0.75 * V / math.pi) ** (2 / 3)
    exact = m * LATENT / (15.0 * 10.0 * area) * 3 * (1 - J_w ** (1 / 3)) / (1 - J_w)
    passes = 0
    while state.liquid[0] < 1:
        state.pass_heat(exact / 1000)
        passes += 1
    assert passes / 1000 == pytest.approx(1.0, abs=0.01)
    assert float(m / (V * state.J_P[0])) == pytest.approx(1000.0, rel=1e-9)


def test_heap_takes_what_its_surface_takes():
    """A ball of many particles takes from air and sun what a ball of its size does, to 15 %."""
    ball = {"shape": "sphere", "radius": 0.3}
    air = {"air_exchange": 10.0, "air_temperature": 0.0, "snow_temperature": -10.0}
    sun = {"air_exchange": 0.0, "sun": 1000.0, "albedo": 0.5, "snow_temperature": -10.0}
    for heat, power in ((air, 100.0 * 4 * math.pi * 0.09), (sun, 500.0 * math.pi * 0.09)):
        sim = simulate([ball], heat)
        sim.solver.begin(0, 0.0)
        assert sim.state.pass_heat(1.0).taken == pytest.approx(power, rel=0.15)


def melting(threads=1, snow=None, precision="float32", **more):
    """A block on the ground that melts in a few seconds."""
    heat = {"air_temperature": 10.0, "sun": 800.0, "heat_speed": 20000.0, "sintering": True} | more
    block = {"shape": "box", "size": [0.2, 0.2, 0.25], "center": [0, 0, 0.2]}
    return simulate(
        [block], heat, [GROUND], -9.81, snow or {"kind": "wet"}, threads=threads, dx=0.08, precision=precision
    )


def test_balance_and_run_off():
    """While a block falls, melts and runs off, heat is what air and sun gave, to rounding."""
    sim = melting()
    start, width = sim.diagnostics(), np.ptp(np.asarray(sim.state.x)[:, 0])
    sim.advance(1.2)
    now = sim.diagnostics()
    assert 0.2 * now.mass < now.water < 0.9 * now.mass
    assert now.heat - start.heat == pytest.approx(now.heat_taken, rel=1e-12)
    water = np.asarray(sim.state.liquid) >= 1
    assert np.ptp(np.asarray(sim.state.x)[water, 0]) > 2 * width
    assert now.mass == start.mass


def test_closed_box_never_drifts():
    """Ten thousand passes over a cloud of all phases without air and sun: not a digit of the sum is lost."""
    sim = simulate([{"shape": "box", "size": [0.1] * 3}], {"air_exchange": 0.0, "snow_temperature": 0.0})
    sim.solver.begin(0, 0.0)
    state = sim.state
    m = np.asarray(state.m)
    state.enthalpy[...] = m * LATENT * np.random.default_rng(1).uniform(-0.3, 1.3, len(m))
    scale, start, spread = np.abs(state.enthalpy).sum(), math.fsum(state.enthalpy), np.ptp(state.enthalpy)
    for _ in range(10_000):
        state.pass_heat(2.0)
    assert math.fsum(state.enthalpy) == pytest.approx(start, abs=1e-12 * scale)
    assert np.ptp(state.enthalpy) < 0.9 * spread  # it did flow


@pytest.mark.parametrize("kind", [None, "powder"])
def test_refrozen_water_is_ice(kind):
    """Water that freezes has the density of ice, no more pores, and is bonded to all that it touches.

    So is that of snow without cohesion. Bonds bear what the strength of ice says: in force over the area as
    3816 Pa is to the 625 Pa + 3.906 Pa (rho0 - 100) of the snow, in steps of 1 %.
    """
    snow = {"kind": kind} if kind else {"theta_s": 0.02}
    air = {"air_exchange": 0.0, "snow_temperature": 0.0}
    sim = simulate([{"shape": "box", "size": [0.1] * 3}], air, snow=snow)
    sim.solver.begin(0, 0.0)
    state = sim.state
    state.enthalpy[...] = np.asarray(state.m) * LATENT
    state.pass_heat(1e-9)
    assert np.all(np.asarray(state.bond) == 0)
    assert sim.diagnostics().bonds == 0
    state.x[...] *= 0.95 * np.cbrt(float(state.m[0] / state.V0[0]) / 1000.0)  # drops shrink from each other
    state.enthalpy[...] = -1.0
    state.pass_heat(1e-9)
    np.testing.assert_allclose(state.m / (state.V0 * state.J_P), 917.0, rtol=1e-6)
    assert np.all(np.asarray(state.liquid) == 0)
    begin, row, values = (np.asarray(a) for a in state.contacts())
    x, r = np.asarray(state.x), np.asarray(state.radius)
    mine = np.repeat(np.arange(sim.count), np.diff(begin))
    overlap = r[mine] + r[row] - np.linalg.norm(x[mine] - x[row], axis=1)
    assert np.all(values[overlap > 1e-9, 0] > 0)
    assert (overlap > 1e-9).sum() > 0
    if kind is None:
        rho0 = 400.0
        stronger = (625 + 3125 * 817 / 800) / (625 + 3125 * (rho0 - 100) / 800)
        np.testing.assert_allclose(state.bond, 0.02 * stronger * (rho0 / 917.0) ** (1 / 3), rtol=0.012)


def test_what_freezes_bit_by_bit_is_bonded_as_the_snow():
    """Bonds of slush bear little, and what the snow's bear once all of it is ice."""
    sim = simulate([{"shape": "box", "size": [0.1] * 3}], {"air_exchange": 0.0, "snow_temperature": 0.0})
    sim.solver.begin(0, 0.0)
    state = sim.state
    for share in (0.97, 0.5, 0.0):
        state.enthalpy[...] = share * np.asarray(state.m) * LATENT - (share == 0.0)
        state.pass_heat(1e-9)
    begin, row, values = (np.asarray(a) for a in state.contacts())
    mine = np.repeat(np.arange(state.count), np.diff(begin))
    bond, radius = np.asarray(state.bond), np.asarray(state.radius)
    least = 0.5 * (bond[mine] + bond[row]) * (radius[mine] + radius[row])
    bonded = values[:, 0] > 0
    assert bonded.sum() > state.count
    assert np.all(values[bonded, 0] >= least[bonded] * (1 - 1e-5))


@pytest.mark.parametrize("melts", [False, True])
def test_sintered_bonds_lose_what_melts(melts):
    """A bond that sintering has strengthened loses the share that melts, in place of all that it gained."""
    heat = {"air_exchange": 0.0, "snow_temperature": 0.0, "sintering": True}
    sim = simulate([{"shape": "box", "size": [0.1] * 3}], heat, snow={"xi": 10.0})
    sim.solver.begin(0, 0.0)
    state = sim.state
    state.pass_heat(1e6)
    grown = np.asarray(state.contacts()[2])[:, 0]
    state.enthalpy[...] = (0.25 if melts else 0.0) * np.asarray(state.m) * LATENT
    state.pass_heat(1e-9)
    left = np.asarray(state.contacts()[2])[:, 0] / grown
    np.testing.assert_allclose(np.median(left), 0.75 if melts else 1.0, rtol=0.02)


def test_sintering():
    """A bond at rest bears more with time, as its 0.21th power, and slower in the cold; up to that of ice."""
    holds = {}
    for celsius in (-5.0, -30.0):
        heat = {"air_exchange": 0.0, "snow_temperature": celsius, "sintering": True, "conductivity": 1e-3}
        sim = simulate([{"shape": "box", "size": [0.1] * 3}], heat, snow={"xi": 10.0})
        sim.solver.begin(0, 0.0)
        born = np.asarray(sim.state.contacts()[2])[:, 0]
        sim.state.pass_heat(1000.0)
        holds[celsius] = np.median(np.asarray(sim.state.contacts()[2])[:, 0] / born)
        sim.state.pass_heat(1e6)
        most = np.asarray(sim.state.contacts()[2])[:, 0] / born
        assert most.max() == pytest.approx((917.0 / 400.0) ** 2.44, rel=1e-3)
    pace = math.exp(-5.86e4 / 8.314 * (1 / 243.15 - 1 / 268.15))
    assert holds[-5.0] == pytest.approx(1001.0**0.21, rel=1e-3)
    assert holds[-30.0] == pytest.approx((1 + 1000.0 * pace) ** 0.21, rel=1e-3)


def parted(kind, rest):
    """Return by how much halves of a block part in 0.25 s after a push of 2 cm/s, over that of free ones.

    Gravity has settled the block in a tight box, where it has lain for `rest` [s]; then both are taken away.
    """
    heat = {"air_exchange": 0.0, "snow_temperature": -2.0, "sintering": True}
    walls = [
        {"shape": "plane", "point": [side * 0.1 * (axis == 0), side * 0.1 * (axis == 1), 0],
         "normal": [-side * (axis == 0), -side * (axis == 1), 0], "mode": "slip"}
        for axis in (0, 1) for side in (-1, 1)
    ]  # fmt: skip
    block = {"shape": "box", "size": [0.2, 0.2, 0.2], "center": [0, 0, 0.1]}
    sim = simulate([block], heat, [GROUND, *walls], -9.81, {"kind": kind}, dx=0.066)
    sim.advance(0.15)
    sim.solver.begin(sim.steps, sim.time)
    sim.state.v[...] = 0.0
    if rest:
        sim.state.pass_heat(rest)
    world = sim.scene.world.model_copy(update={"gravity": (0.0, 0.0, 0.0)})
    sim.change(sim.scene.model_copy(update={"world": world, "colliders": ()}))
    upper = np.asarray(sim.state.x[:, 2]) > np.median(sim.state.x[:, 2])
    ids = np.asarray(sim.state.id)[upper]
    sim.state.v[:, 2] = np.where(upper, 0.02, -0.02)

    def apart():
        above, z = np.isin(sim.state.id, ids), np.asarray(sim.state.x[:, 2])
        return z[above].mean() - z[~above].mean()

    before = apart()
    sim.advance(0.25)
    return (apart() - before) / (0.04 * 0.25)


@pytest.mark.parametrize("kind", ["powder", "cold_dense"])
def test_sintered_snow_holds_together(kind):
    """Snow without cohesion falls apart at a push; after a week of rest it holds."""
    assert parted(kind, 0.0) > 0.8
    assert parted(kind, 7 * 86400.0) < 0.5


def test_same_bits():
    """Threads and a resume in the middle of a thaw change no bit."""
    sims = [melting(threads) for threads in (1, 2, 1)]
    for sim in sims:
        sim.advance(0.123)
    sims[2] = neve.Simulation.restore(sims[2].scene, sims[2].arrays(), threads=3)
    for sim in sims:
        sim.advance(0.1)
    arrays = [sim.arrays() for sim in sims]
    for name, value in arrays[0].items():
        for other in arrays[1:]:
            np.testing.assert_array_equal(value, other[name], err_msg=name)
    assert sims[0].diagnostics() == sims[1].diagnostics()
    assert (np.asarray(sims[0].state.liquid) > 0).any()


def test_heat_cannot_come_or_go():
    """One sentence says so."""
    sim = simulate([{"shape": "sphere", "radius": 0.2}], {})
    with pytest.raises(SceneError, match="heat cannot come or go"):
        sim.change(sim.scene.model_copy(update={"heat": None}))


def test_contacts_that_sinter_unseen_keep_momentum():
    """A contact that sinters before a step has seen it begins without a spring: momentum stays.

    The loose lumps touch and part again; what the lists of neighbours held there before must not count.
    """
    lumps = [
        {"shape": "sphere", "center": (s * 0.13, 0.01 * s, 0), "radius": 0.12, "velocity": (-0.02 * s, 0, 0)}
        for s in (-1, 1)
    ]
    sim = simulate(lumps, {"sintering": True, "air_exchange": 0.0}, snow={"theta_s": 1e-6, "theta_c": 1e-3})
    start = np.array(sim.diagnostics().momentum)
    sim.advance(0.5)
    d = sim.diagnostics()
    assert d.contacts > 0
    scale = math.sqrt(2 * d.mass * (d.kinetic + d.elastic)) + 1e-3 * d.mass
    assert np.abs(np.array(d.momentum) - start).max() < 1e-12 * scale


def test_heat_that_takes_too_many_rounds_is_told():
    """A speed of heat that a pass would not end at is one sentence that names what to lower."""
    lump = {"shape": "sphere", "radius": 0.1}
    sim = simulate([lump], {"conductivity": 1000.0, "heat_speed": 1e6})
    with pytest.raises(Blowup, match=r"rounds .*: lower heat.heat_speed"):
        sim.advance(0.02)
