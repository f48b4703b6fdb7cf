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
    """Heat that comes and goes at random never raises the elastic energy of pressed and rubbing snow."""
    rng = np.random.default_rng(4)
    lumps = [
        {"shape": "sphere", "center": (s * 0.1, 0.02 * s, 0), "radius": 0.1, "velocity": (-2 * s, 0, 0)}
        for s in (-1, 1)
    ]
    sim = simulate(lumps, {"air_exchange": 0.0, "conductivity": 1e-3}, snow=snow, dx=0.04)
    sim.advance(0.012)
    sim.solver.begin(sim.steps, sim.time)
    sim.state.x[...] += 0.1 * np.asarray(sim.state.radius)[:, None] * rng.uniform(-1, 1, (sim.count, 3))
    d = sim.diagnostics()
    assert d.contacts > 50
    assert d.elastic > 0
    for _ in range(40):
        before = sim.diagnostics().elastic
        heat_of(sim, rng.uniform(-0.5, 1.5, sim.count))
        now = sim.diagnostics().elastic
        assert now <= before * (1 + 1e-9)
        shift = 0.02 * np.asarray(sim.state.radius)[:, None]
        sim.state.x[...] += shift * rng.uniform(-1, 1, (sim.count, 3))


def test_what_freezes_keeps_its_force():
    """Water that presses on water pushes as hard once it is ice, and stores less by the ratio of stiffness.

    That of water is a tenth of its snow's. Stored is F^2 / (2 k).
    """
    sim = simulate(
        [{"shape": "box", "size": [0.1] * 3}], {"air_exchange": 0.0}, snow={"law": "drucker_prager"}
    )
    sim.solver.begin(0, 0.0)
    heat_of(sim, 1.0)
    sim.state.x[...] *= 0.65
    before = sim.diagnostics()
    assert before.bonds == 0
    assert before.elastic > 0
    for share in np.linspace(0.99, 0.0, 12):
        heat_of(sim, share - (share == 0.0) * 1e-9)
    assert sim.diagnostics().elastic == pytest.approx(0.1 * before.elastic, rel=1e-6)
    assert sim.diagnostics().bonds > sim.count


@named
def test_melting_makes_no_energy(snow):
    """Snow of any law melts under its own weight: mechanical energy less the work of the ground only falls.

    But for the swing of explicit steps, as in test_energy_never_grows.
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
        snow or {"E0": 3e5}, **more,
    )  # fmt: skip
    sim.state.enthalpy[...] = np.asarray(sim.state.m) * LATENT
    return sim


def test_pool_lies_level():
    """Melt water in a box comes to rest level; frozen there, it stays, and gains no energy.

    Its spheres, which fill 0.55 of the volume of the water, lie as densely as they can without order, 0.64:
    the pool has 1164 kg/m3, to the 5 % by which it is soft and does not fill the corners.
    """
    sim = pool()
    sim.advance(1.0)
    d, x = sim.diagnostics(), np.asarray(sim.state.x)
    assert np.sqrt(2 * d.kinetic / d.mass) < 0.01
    r = float(sim.state.radius[0])
    corner = 2 * (x[:, 0] > 0) + (x[:, 1] > 0)
    tops = [x[corner == i, 2].max() for i in range(4)]
    assert np.ptp(tops) < r
    assert d.mass / 0.04 / (2 * x[:, 2].mean()) == pytest.approx(1000.0 * 0.64 / 0.55, rel=0.05)
    before, height = energy(sim), x[:, 2].mean()
    sim.state.enthalpy[...] = -1e-3 * LATENT * np.asarray(sim.state.m)
    for _ in range(10):
        sim.advance(0.05)
        now = energy(sim)
        assert now <= before + 1e-4 * abs(before)
        before = now
    assert np.all(np.asarray(sim.state.liquid) == 0)
    assert np.asarray(sim.state.x)[:, 2].mean() == pytest.approx(height, rel=0.03)
