"""Snow as dense as ice: what it resists with, that it spreads, and that lighter snow does not notice."""

import logging

import numpy as np
import pytest
from reference import ice, snow
from verification.scenes import ball, box, oracle, scene, simulate

from neve.mpm.state import density

FLOOR = {"shape": "plane", "point": (0, 0, 0), "normal": (0, 0, 1), "mu_c": 0.3}


def test_energy_pressure_and_modulus(core, precision, eps):
    """p = dU/dz; modulus = dp/dz + p, that of a fluid: rho0 c^2 = -J dp_Cauchy/dlnJ; dp/dz = K beyond 0.1.

    The modulus to come bounds it from above: (z / z_s)^(1/32) too large at most, and a part 0.025 for p.
    """
    z = np.linspace(0, 0.3, 601)
    p, U, modulus = (np.asarray(a, float) for a in core.ice(z.astype(precision)))
    np.testing.assert_allclose(p, ice.pressure(z), rtol=20 * eps, atol=1e-3)
    np.testing.assert_allclose(U, ice.energy(z), rtol=20 * eps, atol=1e-3)
    h = 1e-5
    slope = (ice.pressure(z + h) - ice.pressure(z - h)) / (2 * h)
    exact = (slope + ice.pressure(z))[1:]
    assert (modulus[1:] > 0.999 * exact).all()
    assert (modulus[1:] < 1.03 * exact * np.maximum(1, (0.1 / z[1:]) ** (1 / 32)) + 1e3).all()
    np.testing.assert_allclose(modulus[z > 0.101], exact[z[1:] > 0.101], rtol=1e-3)
    work = (ice.energy(z + h) - ice.energy(z - h)) / (2 * h)
    np.testing.assert_allclose(work[1:], ice.pressure(z)[1:], rtol=1e-3, atol=1)
    assert (modulus - p)[-1] == pytest.approx(8.9e9, rel=1e-5)
    assert (np.diff(modulus) > 0).all()


@pytest.mark.parametrize("speed", [10.0, 100.0, 1000.0, 5000.0])
def test_modulus_to_come_is_that_where_the_blow_ends(core, precision, eps, speed):
    """U(z_end) = U(z) + 917 kg/m3 speed^2 / 2: the modulus of a blow is that of rest there, all the way."""
    end = np.linspace(0, 1.5, 400_001)
    stop = np.interp(0.5 * 917 * speed**2, ice.energy(end), end)
    z = np.linspace(0, 0.999 * stop, 50)
    left = np.sqrt(2 / 917 * (ice.energy(stop) - ice.energy(z)))
    at_rest = core.ice(np.array([stop], precision))[2][0]
    for at, fast in zip(z, left, strict=True):
        assert core.ice(np.array([at], precision), fast)[2][0] == pytest.approx(at_rest, rel=1e-4)


@pytest.mark.parametrize("law", ["stomakhin2013", "neo_hookean", "hencky", "drucker_prager", "cam_clay"])
@pytest.mark.parametrize("rho0", [250.0, 850.0, 1500.0])
def test_stress_and_energy_of_a_state(law, rho0):
    """tau = that of the law - p(z) I, and U(z) is in the elastic energy: J_P from 1.2 down to 0.15.

    Up to J_ice = min(rho0 / 917, 0.9) the stress is the law's alone, to the bit.
    """
    sim = simulate(scene([box()], snow={"law": law, "rho0": rho0}, dx=0.05, initial_volume="sampled"))
    n = sim.count
    sim.state.J_P[...] = np.geomspace(1.2, 0.15, n)
    sim.solver.begin(1, 0.0)
    p, _ = oracle(sim)
    z = ice.beyond(p)
    order = np.argsort(np.asarray(sim.state.id))
    tau = np.array(sim.state.tau)[order]
    alone = snow.kirchhoff(p.F_E, p.J_P, p.law)
    pressure = -(tau[:, 0] - alone[:, 0, 0])
    assert 0.1 < (z > 0).mean() < 0.95
    np.testing.assert_allclose(pressure, ice.volume(p) * ice.pressure(z), rtol=1e-9, atol=1e-6)
    assert (tau[z == 0] == 0).all()  # F_E = I
    elastic = (p.V0 * (snow.energy(p.F_E, p.J_P, p.law) + ice.volume(p) * ice.energy(z))).sum()
    assert sim.diagnostics().elastic == pytest.approx(elastic, rel=1e-9)


def test_elastic_snow_is_no_snow_that_packs():
    """Without plastic flow there are no grains to push together: the elasticity alone, at any density."""
    sim = simulate(scene([box()], snow={"plasticity": "none"}, dx=0.05))
    sim.state.J_P[...] = 0.1
    sim.solver.begin(1, 0.0)
    assert (np.asarray(sim.state.tau) == 0).all()


@pytest.mark.parametrize("kind", ["reference", "fresh", "wet", "cold_dense", "powder"])
def test_ball_at_a_wall_becomes_no_sheet(kind):
    """A ball at 60 m/s: no snow is denser than 917 kg/m3 by more than a tenth, none of its energy is new.

    What it loses in height it wins in width: it was 0.4 m wide. (It used to be a disc of a few millimetres
    and ten times the density of ice.)
    """
    fast = ball(radius=0.2, center=(0, 0, 0.25), velocity=(0, 0, -60))
    numerics = {"dx": 0.05, "precision": "float32", "dt": "auto", "initial_volume": "sampled"}
    sim = simulate(scene([fast], [FLOOR], snow={"kind": kind}, **numerics))
    start, most = sim.diagnostics(), 0.0
    for _ in range(10):
        sim.advance(1.5e-3)
        now = sim.diagnostics()
        most = max(most, float(density(sim.state).max()))
        assert now.kinetic + now.affine + now.elastic < 1.01 * start.kinetic
    assert most < 1.1 * 917
    assert np.ptp(np.asarray(sim.state.x)[:, 0]) > 0.6


@pytest.mark.parametrize("transfer", ["apic", "aflip", "polypic"])
@pytest.mark.parametrize("rho0", [880.0, 1900.0])
def test_soft_snow_meets_ice_in_short_steps(rho0, transfer):
    """Two soft balls of nearly the density of ice meet at 1.5 times their wave speed: nothing is gained.

    Their own steps are so long that one of them would carry snow far into the ice, whose stiffness, ten
    million times theirs, it would meet without having been slowed down.
    """
    soft = {"law": "cam_clay", "rho0": rho0, "E0": 1e3, "nu": 0.3, "p0": 20.0, "xi": 0.1}
    fast = 1.5 * np.sqrt(1.35 * 1e3 / rho0)
    balls = [
        ball(radius=0.2, center=(side * 0.25, 0, 0.03 * side), velocity=(-side * fast, 0, 0))
        for side in (-1, 1)
    ]
    sim = simulate(scene(balls, snow=soft, dx=0.1, dt="auto", cfl=0.5, strain_max=0.5, transfer=transfer))
    start = sim.diagnostics()
    for _ in range(8):
        sim.advance(0.02 / fast)
        now = sim.diagnostics()
        assert now.kinetic + now.affine + now.elastic < 1.02 * (start.kinetic + start.affine)
    assert sim.steps > 20


def test_snow_under_a_plate_goes_sideways():
    """A block of 0.2 m pressed to 0.02 m: ice would fill 0.044 m of it, so it must spread by a half."""
    plate = {
        "shape": "box",
        "size": (1, 1, 0.2),
        "keyframes": [{"t": 0, "position": (0, 0, 0.301)}, {"t": 0.05, "position": (0, 0, 0.12)}],
    }
    numerics = {"dx": 0.05, "precision": "float32", "dt": "auto", "initial_volume": "sampled"}
    sim = simulate(scene([box(center=(0, 0, 0.1))], [FLOOR | {"mu_c": 0}, plate], **numerics))
    sim.advance(0.05)
    assert density(sim.state).max() < 1.1 * 917
    wide = np.ptp(np.asarray(sim.state.x)[:, :2], axis=0)
    assert (wide > 1.3 * 0.2).all()


def test_snow_that_is_too_dense_is_named(caplog):
    """One sentence: the source, its density, what to change; and once, not in every frame."""
    sim = simulate(scene([box(), box(center=(1, 0, 0), snow={"rho0": 300})], initial_volume="sampled"))
    first = int(np.flatnonzero(np.asarray(sim.state.x)[:, 0] > 0.5)[0])
    sim.state.J_P[first] = 0.2
    with caplog.at_level(logging.WARNING, logger="neve"):
        sim.advance(1e-5)
        sim.advance(1e-5)
    told = [m for m in (record.getMessage() for record in caplog.records) if "kg/m3" in m]
    assert len(told) == 1
    assert told[0].startswith("snow of sources.1 is pressed to 1500 kg/m3")
    assert "ice has 917 kg/m3" in told[0]
