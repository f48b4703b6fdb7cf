"""Known answer 26: drucker_prager stays in its cone, bears pressure, and keeps count of volume."""

import numpy as np
import pytest
from reference.laws import LAWS
from verification.laws.test_25_cam_clay import invariants, pressed
from verification.material import near_identity, respond

from neve import _core


@pytest.fixture(params=["drucker_prager", "drucker_prager cohesive"])
def sand(request):
    return LAWS[request.param]


def cone(law):
    """M_phi = 6 sin phi / (3 - sin phi), and p_t = cohesion / tan phi [Pa]."""
    phi = np.radians(law.friction_angle)
    return 6 * np.sin(phi) / (3 - np.sin(phi)), law.cohesion / np.tan(phi)


def test_in_or_on_the_cone(core, precision, eps, sand):
    """q <= M_phi (p + p_t) over 500 random F, on it for what slid; rounding 8 eps M_c, twice with M_phi."""
    F = near_identity(500, 0.05, seed=2).astype(precision)
    F_E, _, tau, _ = respond(core, F, 1.0, sand, precision)
    p, q = invariants(tau)
    M_phi, p_t = cone(sand)
    over = (q - M_phi * (p + p_t)) / sand.M_c
    assert (over <= 16 * eps).all()
    slid = (np.asarray(F_E, precision) != F).any((1, 2))
    assert slid.mean() > 0.1
    assert (np.abs(over[slid]) <= 16 * eps).all()


def test_pressure_is_elastic(core, precision, eps, sand):
    """Pressed on all sides to 0.6 of its length: F_E is F, J_P one, p = -K ln J; 16 eps M_c."""
    s = np.linspace(0.6, 0.9999, 50).astype(precision)
    F = s[:, None, None] * np.eye(3, dtype=precision)
    F_E, J_P, tau, _ = respond(core, F, 1.0, sand, precision)
    np.testing.assert_allclose(F_E, F, atol=10 * eps, rtol=0)
    np.testing.assert_array_equal(J_P, 1)
    p, q = invariants(tau)
    np.testing.assert_allclose(p, -3 * sand.K * np.log(s.astype(float)), atol=16 * eps * sand.M_c)
    np.testing.assert_allclose(q, 0, atol=16 * eps * sand.M_c)


def test_apex(core, precision, eps, sand):
    """Pulled by 1.2 on each axis: tension p_t alone is left, and J_P holds the volume beyond the apex."""
    F_E, J_P, tau, _ = respond(core, pressed(1.2), 1.0, sand, precision)
    p, q = invariants(tau)
    _, p_t = cone(sand)
    assert p[0] == pytest.approx(-p_t, abs=16 * eps * sand.M_c)
    assert q[0] == pytest.approx(0, abs=16 * eps * sand.M_c)
    assert J_P[0] == pytest.approx(1.2**3 / np.exp(p_t / sand.K), rel=30 * eps)
    np.testing.assert_allclose(F_E[0], np.exp(p_t / sand.K / 3) * np.eye(3), atol=10 * eps)


def test_cohesion_in_shear():
    """Without pressure q is at most M_phi p_t = 6 cohesion cos phi / (3 - sin phi); float64, 1e-9."""
    law = LAWS["drucker_prager cohesive"]
    F = np.tile(np.diag([1.05, 1 / 1.05, 1.0]), (1, 1, 1))
    p, q = invariants(respond(_core.f64, F, 1.0, law)[2])
    phi = np.radians(law.friction_angle)
    assert p[0] == pytest.approx(0, abs=1e-9 * law.M_c)
    assert q[0] == pytest.approx(6 * law.cohesion * np.cos(phi) / (3 - np.sin(phi)), rel=1e-9)


def test_torn_snow_pushed_together_is_no_larger(sand):
    """Volume correction: torn by 1.3, sheared, pushed to 0.97 in steps, it has the pressure of 0.97 at once.

    Without it the push to J = 0.97 from J = 1.3 would press on snow that counts as dense at 1.3. 200 steps
    of float64: 1e-10.
    """
    F_E, J_P = np.eye(3)[None], np.ones(1)
    target, now = (
        np.concatenate([np.linspace(0, np.log(1.3), 60), np.linspace(np.log(1.3), np.log(0.97), 140)]),
        0.0,
    )
    for e in target:
        step = np.exp((e - now) / 3) * np.diag([1.001, 1 / 1.001, 1.0])
        F_E, J_P, tau, _ = respond(_core.f64, step @ F_E, J_P, sand)
        now = e
    assert J_P[0] == 1
    assert np.linalg.det(F_E[0]) == pytest.approx(0.97, rel=1e-10)
    assert invariants(tau)[0][0] == pytest.approx(-sand.K * np.log(0.97), rel=1e-9)


def test_tearing_stores_its_work():
    """dPsi = tr tau dlnJ / 3 on the way apart and back, torn by 1.3: what p_t did is stored.

    The trapezoidal rule is exact but in the step over the apex, where tension bends: K de^2 / 8 of it.
    """
    law = LAWS["drucker_prager cohesive"]
    steps = np.concatenate([np.linspace(0, np.log(1.3), 400), np.linspace(np.log(1.3), -0.01, 400)])
    F_E, J_P, tension, stored = np.eye(3)[None], np.ones(1), [0.0], [0.0]
    for de in np.diff(steps):
        F_E, J_P, tau, psi = respond(_core.f64, np.exp(de / 3) * F_E, J_P, law)
        tension.append(np.trace(tau[0]) / 3)
        stored.append(psi[0])
    done = np.cumsum(0.5 * (np.array(tension[1:]) + tension[:-1]) * np.diff(steps))
    _, p_t = cone(law)
    assert stored[399] == pytest.approx(p_t * (np.log(1.3) - 0.5 * p_t / law.K), rel=1e-9)
    np.testing.assert_allclose(stored[1:], done, atol=law.K * np.abs(np.diff(steps)).max() ** 2 / 4)
    assert stored[-1] == pytest.approx(0.5 * law.K * 0.01**2, rel=1e-9)


def test_shear_keeps_volume(sand):
    """Sliding does not dilate: pressed to 0.95 and sheared for 100 steps, J_E and p stay: 1e-10."""
    F_E, J_P = pressed(0.95 ** (1 / 3)), np.ones(1)
    for _ in range(100):
        F_E, J_P, tau, _ = respond(_core.f64, np.diag([1.01, 1 / 1.01, 1.0]) @ F_E, J_P, sand)
    p, q = invariants(tau)
    M_phi, p_t = cone(sand)
    assert np.linalg.det(F_E[0]) == pytest.approx(0.95, rel=1e-10)
    assert p[0] == pytest.approx(-sand.K * np.log(0.95), rel=1e-9)
    assert q[0] == pytest.approx(M_phi * (p[0] + p_t), rel=1e-9)
