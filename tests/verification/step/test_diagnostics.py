"""Mass, momentum and energies against sums in NumPy, and against physics."""

import numpy as np
import pytest
from reference import snow
from verification.scenes import ball, box, march, oracle, scene, simulate

GRAVITY = (0.5, -1.0, -9.81)


def thrown(precision, transfer="apic", **numerics):
    return scene(
        [
            box(center=(0.3, 0.1, 0.2), velocity=(2, -1, 0.5), spin=(1, 2, 3)),
            ball(center=(-0.4, 0, 0), radius=0.12, snow={"xi": 4.0, "E0": 6e4}, velocity=(0, 0, -3)),
        ],
        [{"shape": "plane", "point": (0, 0, -0.13), "normal": (0, 0, 1)}],
        gravity=GRAVITY,
        precision=precision,
        transfer=transfer,
        **numerics,
    )


@pytest.mark.parametrize("steps", [0, 60])
def test_sums(precision, eps, transfer, steps):
    """Sums in double of the particles' values: float64's rounding, and this precision's for elastic energy.

    Psi comes from stretches right to 4 eps, so each particle's is right to M_c h (|strain| 8 eps + 16 eps^2).
    """
    sim = simulate(thrown(precision, transfer))
    if steps:
        march(sim, steps)
    d, (p, _) = sim.diagnostics(), oracle(sim)
    assert d.mass == pytest.approx(p.m.sum(), rel=1e-12)
    np.testing.assert_allclose(d.momentum, p.m @ p.v, atol=1e-12 * p.m.sum() * 10)
    assert d.kinetic == pytest.approx(0.5 * p.m @ (p.v**2).sum(1), rel=1e-12)
    gravity = np.asarray(GRAVITY, precision).astype(float)
    assert d.potential == pytest.approx(-p.m @ (p.x @ gravity), rel=1e-12, abs=1e-12)
    psi = snow.energy(p.F_E, p.J_P, p.law)
    strain = np.abs(np.linalg.svd(p.F_E, compute_uv=False) - 1).max(1)
    unit = p.law.M_c * p.law.hardening(p.J_P) * p.V0
    assert abs(d.elastic - p.V0 @ psi) <= (unit * (16 * eps * strain + 64 * eps**2)).sum() + 1e-13 * d.elastic
    assert d.particles == sim.state.count
    assert d.blocks == sim.solver.grid.blocks
    if steps:
        assert d.elastic > 0


def test_free_flight_keeps_energy(spline):
    """Kinetic and potential energy of falling snow: symplectic Euler drifts by m g^2 dt t / 2, exactly.

    E(n) - E(0) with v = g n dt and z = g dt^2 n (n + 1) / 2: m g^2 dt^2 (n^2 - n (n + 1)) / 2 = -m g^2 dt^2
    n / 2.
    """
    n, dt, g = 100, 4e-4, 9.81
    sim = simulate(scene([ball(velocity=(1, 2, 3))], gravity=(0, 0, -g), dt=dt, spline=spline))
    a = sim.diagnostics()
    b = march(sim, n).diagnostics()
    drift = b.kinetic + b.potential - a.kinetic - a.potential
    assert drift == pytest.approx(-a.mass * g**2 * dt**2 * n / 2, rel=1e-6)
    assert b.mass == a.mass


def test_momentum_of_gravity(transfer, spline):
    """d/dt sum m v = M g: after n steps sum m v = sum m v0 + M g n dt, colliders aside; 1e-11 in float64."""
    n, dt = 50, 1e-4
    description = scene(
        [ball(velocity=(1, 0, 2), spin=(5, 0, 9)), box(center=(0.2, 0, 0), velocity=(-2, 0, 0))],
        gravity=GRAVITY, spline=spline, transfer=transfer, dt=dt,
    )  # fmt: skip
    sim = simulate(description)
    a = sim.diagnostics()
    b = march(sim, n).diagnostics()
    expected = np.array(a.momentum) + a.mass * np.array(GRAVITY) * n * dt
    np.testing.assert_allclose(b.momentum, expected, rtol=0, atol=1e-11 * a.mass)
