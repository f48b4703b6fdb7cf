"""Known answers of smoothed particles: a column, the oedometer, two cubes that meet, stiff snow."""

import numpy as np
import pytest
from verification.sph.common import smoothed

from neve.validate.scenes import box, duct, moduli, plane
from neve.validate.snow.oedometer import answer

G = 9.81


def test_a_column_carries_its_weight():
    """Elastic snow in a smooth duct at rest: the floor bears the weight, and sigma_zz falls with height.

    The stress inside is a tenth above that of the weight: particles at the walls carry less than their share.
    """
    E0, nu = 1e6, 0.2
    sim = smoothed(
        [box((0, 0, 0), (0.4, 0.4, 1.0))],
        [*duct(0.4, 0.4), plane((0, 0, 0), (0, 0, 1), mu_c=0.0)],
        (0.0, 0.0, -G),
        {"E0": E0, "nu": nu, "plasticity": "none"},
        sampling="regular",
    )
    sim.advance(0.6)
    weight = sim.diagnostics().mass * G
    sim.advance(0.1)
    assert -sim.stats.exchanged[:, 2].sum() == pytest.approx(0.1 * weight, rel=1e-4)
    assert -sim.stats.exchanged[-1, 2] == pytest.approx(0.1 * weight, rel=0.03)
    G0, lam0, _ = moduli(E0, nu)
    F, z = np.array(sim.state.F_E), np.array(sim.state.x[:, 2])
    sigma = lam0 * (1.0 / np.linalg.det(F) - 1.0) - 2.0 * G0 * (F[:, 2, 2] - 1.0)
    top = z.max() + 0.025
    for low in np.arange(0.3, 0.9, 0.1):
        here = (z >= low) & (z < low + 0.1)
        assert sigma[here].mean() == pytest.approx(400.0 * G * (top - z[here].mean()), rel=0.16)


def law(s):
    """Axial pressure of uniaxial strain s [Pa]: lam (1 / k - 1) + 2 G (1 - k), hardened; k >= 0.975."""
    G0, lam0, _ = moduli(1.4e5, 0.2)
    k = np.maximum(s, 0.975)
    return np.exp(10.0 * (1.0 - s / k)) * (lam0 * (1.0 / k - 1.0) + 2.0 * G0 * (1.0 - k))


def test_the_oedometer_follows_the_law():
    """Default snow in a smooth duct under a piston: its force is that of the law, within a fifth.

    s is the height of the middle half over that at birth: at piston and floor the snow gives way a little
    first. The material point method's Kirchhoff stress makes 1 / J_P of it: by as much its curve, `answer`,
    is above.
    """
    height, rate = 0.4, 0.5
    sim = smoothed(
        [box((0, 0, 0), (0.2, 0.2, height))],
        [
            *duct(0.2, 0.2),
            plane((0, 0, 0), (0, 0, 1)),
            plane((0, 0, height), (0, 0, -1), velocity=[0.0, 0.0, -rate * height]),
        ],
        sampling="regular",
    )
    z = np.array(sim.state.x)[np.argsort(np.asarray(sim.state.id)), 2]
    low, high = z < 0.13, z > 0.27

    def local():
        now = np.array(sim.state.x)[np.argsort(np.asarray(sim.state.id)), 2]
        return (now[high].mean() - now[low].mean()) / (z[high].mean() - z[low].mean())

    sim.state.v[:, 2] = -rate * np.asarray(sim.state.x)[:, 2]
    sim.advance(0.05 / rate)
    pressure = 0.0
    for _ in range(6):
        first = local()
        sim.advance(0.05 / rate)
        s = np.linspace(first, local(), 51)
        pressure = sim.stats.exchanged[-1, 2] * rate / 0.05 / 0.2**2
        assert pressure == pytest.approx(law(s).mean(), rel=0.2)
        axial, _ = answer(s)
        assert -axial.mean() == pytest.approx((law(s) / np.minimum(s / 0.975, 1.0)).mean(), rel=0.03)
    assert pressure > 10 * law(np.array(0.975))


def test_two_cubes_meet_and_part():
    """Two elastic cubes at +-5 m/s: they stop each other, are pressed together, and bounce apart as wholes.

    The scene of SPlisHSPlasH's compressible solver (lam = 1e5 Pa, 1000 kg/m3), with 1000 particles each.
    """
    cube = {"shape": "box", "size": (0.8, 0.8, 0.8)}
    sim = smoothed(
        [
            cube | {"center": (-0.5, 0, 0), "velocity": (5, 0, 0)},
            cube | {"center": (0.5, 0, 0), "velocity": (-5, 0, 0)},
        ],
        (),
        (0.0, 0.0, 0.0),
        {"rho0": 1000.0, "E0": 3.6e5, "nu": 0.2, "plasticity": "none"},
        dx=0.08,
        dt_max=5e-3,
        sampling="regular",
    )
    order = np.argsort(np.asarray(sim.state.id))
    left = np.array(sim.state.x)[order, 0] < 0
    before = sim.diagnostics()
    volume, elastic = 1.0, 0.0
    for _ in range(30):
        sim.advance(0.01)
        d = sim.diagnostics()
        volume = min(volume, float(np.mean(np.linalg.det(np.asarray(sim.state.F_E)))))
        elastic = max(elastic, d.elastic)
        assert d.kinetic + d.elastic < 1.001 * before.kinetic
    v = np.array(sim.state.v)[np.argsort(np.asarray(sim.state.id)), 0]
    assert volume < 0.97
    assert elastic > 0.1 * before.kinetic
    assert v[left].mean() < -0.5
    assert v[~left].mean() == pytest.approx(-v[left].mean(), rel=1e-6)
    assert abs(sim.diagnostics().momentum[0]) < 1e-10 * before.mass * 5.0


def test_steps_far_beyond_those_of_waves_are_stable():
    """At E0 = 5e6 Pa a wave crosses 23 particles in one step of 0.01 s: a block at rest stays so."""
    sim = smoothed(
        [{"shape": "box", "center": (0, 0, 0.15), "size": (0.3, 0.3, 0.3)}],
        [{"shape": "plane"}],
        (0.0, 0.0, -G),
        {"E0": 5e6},
        precision="float32",
        sampling="regular",
    )
    sim.advance(0.5)
    assert sim.stats.steps == 50
    d = sim.diagnostics()
    assert d.kinetic < 1e-4 * d.mass
    assert np.asarray(sim.state.x)[:, 2].max() > 0.27
