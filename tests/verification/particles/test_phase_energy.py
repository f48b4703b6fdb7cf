"""Melting and freezing of particles make no mechanical energy; pools of what has melted lie level."""

import numpy as np
import pytest
from verification.particles.common import energy
from verification.particles.test_heat import GROUND, melting, simulate

from neve.heat.enthalpy import LATENT

LAWS = [
    {"xi": 10.0},
    {"kind": "wet"},
    {"kind": "powder"},
    {"kind": "fresh"},
    {"law": "drucker_prager", "cohesion": 500.0, "E0": 1e5},
    {"plasticity": "none", "E0": 1e5},
]
named = pytest.mark.parametrize("snow", LAWS, ids=lambda snow: next(iter(snow.values())))


def heat_of(sim, share):
    """Give all particles, or each, this share of what melts it, which flows nowhere."""
    sim.state.enthalpy[...] = np.asarray(sim.state.m) * LATENT * share
    sim.state.pass_heat(1e-9)


@named
def test_no_phase_change_gives_elastic_energy(snow):
    """Heat that comes and goes at random over pressed, stretched and rubbing snow never raises its elastic energy."""
    rng = np.random.default_rng(4)
    lumps = [
        {"shape": "sphere", "center": (s * 0.1, 0.02 * s, 0), "radius": 0.1, "velocity": (-2 * s, 0, 0)}
        for s in (-1, 1)
    ]
    sim = simulate(lumps, {"air_exchange": 0.0, "conductivity": 1e-6}, snow=snow, dx=0.04)
    sim.advance(0.012)
    assert sim.diagnostics().contacts > 50
    sim.solver.begin(sim.steps, sim.time)
    sim.state.x[...] += 0.1 * np.asarray(sim.state.radius)[:, None] * rng.uniform(-1, 1, (sim.count, 3))
    seen = sim.diagnostics().elastic
    assert seen > 0
    for _ in range(40):
        before = sim.diagnostics().elastic
        heat_of(sim, rng.uniform(-0.5, 1.5, sim.count))
        now = sim.diagnostics().elastic
        assert now <= before * (1 + 1e-9)
        sim.state.x[...] += 0.02 * np.asarray(sim.state.radius)[:, None] * rng.uniform(-1, 1, (sim.count, 3))


def test_what_freezes_keeps_its_force():
    """Water that presses on water pushes as hard once both are ice, and stores less by the ratio of stiffness.

    That of water is a tenth of its snow's. Stored is F^2 / (2 k).
    """
    sim = simulate(
        [{"shape": "box", "size": [0.1] * 3}], {"air_exchange": 0.0}, snow={"law": "drucker_prager"}
    )
    sim.solver.begin(0, 0.0)
    heat_of(sim, 1.0)
    sim.state.x[...] *= 0.8
    before = sim.diagnostics()
    assert before.bonds == 0
    assert before.elastic > 0
    for share in np.linspace(0.99, 0.0, 12):
        heat_of(sim, share - (share == 0.0) * 1e-9)
    assert sim.diagnostics().elastic == pytest.approx(0.1 * before.elastic, rel=1e-6)
    assert sim.diagnostics().bonds > 3 * sim.count


@named
def test_melting_makes_no_energy(snow):
    """Snow of any law that melts under its own weight: mechanical energy, less the work of the ground, only falls,
    but for the swing of explicit steps, as in test_energy_never_grows.
    """
    sim = melting(snow=snow, precision="float64", air_temperature=30.0)
    start = lowest = energy(sim)
    for _ in range(60):
        sim.advance(0.02)
        now = energy(sim)
        assert now <= lowest + 2e-3 * abs(start)
        lowest = min(lowest, now)
    assert sim.diagnostics().water > 0.1 * sim.diagnostics().mass


def pool(height=0.3, snow=None, **more):
    """Make a column of snow in a tight box that is all water, 0.2 m by 0.2 m."""
    walls = [
        {"shape": "plane", "point": [side * 0.1 * (axis == 0), side * 0.1 * (axis == 1), 0],
         "normal": [-side * (axis == 0), -side * (axis == 1), 0], "mode": "slip"}
        for axis in (0, 1) for side in (-1, 1)
    ]  # fmt: skip
    block = {"shape": "box", "size": [0.2, 0.2, height], "center": [0, 0, height / 2]}
    sim = simulate(
        [block], {"air_exchange": 0.0, "snow_temperature": 0.0}, [*walls, GROUND], -9.81,
        snow or {"E0": 1e5}, **more,
    )  # fmt: skip
    sim.state.enthalpy[...] = np.asarray(sim.state.m) * LATENT
    return sim


def test_pool_lies_level():
    """Melt water in a box comes to rest level; frozen there, it stays, and gains no energy."""
    sim = pool()
    sim.advance(1.5)
    d, x = sim.diagnostics(), np.asarray(sim.state.x)
    assert np.sqrt(2 * d.kinetic / d.mass) < 0.01
    r = float(sim.state.radius[0])
    tops = [x[(x[:, 0] > 0) == a, 2].max() if b is None else x[((x[:, 0] > 0) == a) & ((x[:, 1] > 0) == b), 2].max()
            for a in (True, False) for b in (True, False)]  # fmt: skip
    print(tops, r, 2 * x[:, 2].mean(), d.mass / 0.04 / 1000)
    assert np.ptp(tops) < r
    before, height = energy(sim), x[:, 2].mean()
    sim.state.enthalpy[...] = -1e-3 * LATENT * np.asarray(sim.state.m)
    for _ in range(10):
        sim.advance(0.05)
        now = energy(sim)
        assert now <= before + 1e-4 * abs(before)
        before = now
    assert np.all(np.asarray(sim.state.liquid) == 0)
    assert np.asarray(sim.state.x)[:, 2].mean() == pytest.approx(height, rel=0.03)
