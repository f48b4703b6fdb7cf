"""What pressed particles end at: density against force, and the force that tears them apart."""

import math

import numpy as np
import pytest
from verification.particles.common import pair_of_particles, particles

from neve.scene.errors import SceneWarning


def column(count, snow, **plate):
    """Make a column of single particles on a sticky plane, under a sticky plate."""
    a = 0.05
    plates = [
        {"shape": "plane", "mode": "sticky"},
        {"shape": "box", "center": (0, 0, count * a + 0.05), "size": (0.3, 0.3, 0.1), "mode": "sticky"}
        | plate,
    ]
    with pytest.warns(SceneWarning, match="cells"):
        return particles(
            [{"shape": "box", "center": (0, 0, count * a / 2), "size": (a, a, count * a)}], plates, snow=snow,
            sampling="regular", particles_per_cell=1,
        )  # fmt: skip


def test_density_under_a_force():
    """Two particles that plates press slowly and hold have the density rho of F = Y(rho) pi r^2, to 1 %.

    Y = E0 theta_c exp((rho - rho0) / 100), F as the plate feels it, r from the density; from once to ten
    times the force at which they yield first.
    """
    snow, top = {"E0": 1e5, "theta_c": 0.005, "theta_s": 0.05}, 0.15
    keys = [(0.0, 0.0), *((t, i) for i in range(1, 5) for t in (12.5 * i - 0.5, 12.5 * i))]
    frames = [{"t": t, "position": (0, 0, top - 0.006 * s)} for t, s in keys]
    sim = column(2, snow, keyframes=frames)
    m, r0 = float(sim.state.m[0]), float(sim.state.radius[0])
    rho0, first, seen = m / 0.05**3, 500.0 * math.pi * r0**2, []
    for _ in range(4):
        sim.advance(12.3)
        before = sim.exchanged[1, 2]
        sim.advance(0.2)
        force = abs(sim.exchanged[1, 2] - before) / 0.2
        rho, r = m / (0.05**3 * np.asarray(sim.state.J_P)), np.asarray(sim.state.radius)
        np.testing.assert_allclose(r, r0 * (rho0 / rho) ** (1 / 3), rtol=1e-9)
        bearable = 500.0 * np.exp((rho - rho0) / 100.0) * math.pi * r**2
        np.testing.assert_allclose(force / bearable, 1.0, atol=0.01)
        seen.append(force / first)
    assert seen[0] < 2
    assert seen[3] > 10


def force_that_tears(density):
    """Return the force [N] that tears a bond of two particles of this density [kg/m3] apart.

    The snow, of 400 kg/m3, is compacted before it is bonded.
    """
    sim, _ = pair_of_particles(-0.3, snow={"theta_s": 0.02, "E0": 1e5})
    rho0 = float(sim.state.m[0] / sim.state.V0[0])
    J = rho0 / density
    sim.state.J_P[:2] = J
    sim.state.radius[:2] *= J ** (1 / 3)
    sim.state.x[1, 0] = 2 * float(sim.state.radius[0])
    sim.solver._derive()
    sim.solver._bond(0)
    k, r = float(sim.state.k[0]), float(sim.state.radius[0])
    hold = np.asarray(sim.state.contacts()[2])[:, 0].max()
    return k * hold, r


@pytest.mark.parametrize("density", [500.0, 700.0, 900.0])
def test_strength_of_compacted_snow(density):
    """What breaks a new bond over r^2 grows as the cohesive strength 625 Pa at 100 kg/m3 to 3750 Pa at 900.

    Forces go in steps of 1 %.
    """
    before, r0 = force_that_tears(400.0)
    now, r = force_that_tears(density)
    grown = (625 + 3125 * (density - 100) / 800) / (625 + 3125 * 300 / 800)
    assert now / r**2 == pytest.approx(grown * before / r0**2, rel=0.012)


def test_bonds_that_are_pressed_grow_stronger():
    """The bond of two particles that plates press bears what their density says, not as at birth."""
    sim = column(2, {"E0": 1e5, "theta_c": 0.005, "theta_s": 0.02}, velocity=(0, 0, -0.004))
    born, r0 = np.asarray(sim.state.contacts()[2])[:, 0].max(), float(sim.state.radius[0])
    sim.advance(3.5)
    assert sim.diagnostics().bonds == 1
    hold, r = np.asarray(sim.state.contacts()[2])[:, 0].max(), np.asarray(sim.state.radius)
    rho = 400.0 / np.asarray(sim.state.J_P)
    assert rho.min() > 550
    grown = np.mean((625 + 3125 * (rho - 100) / 800) / (625 + 3125 * 300 / 800) * (r / r0) ** 2)
    assert grown > 1.08
    assert hold / born == pytest.approx(grown, rel=0.012)
