"""Known answer 13: snow in a rigid ring, compressed to s of its height (the oedometer of soil mechanics)."""

from itertools import pairwise

import numpy as np
import pytest
from reference import snow
from verification.material import DEFAULT, respond
from verification.scenes import box, march, oracle, scene, simulate

from neve import _core

TABLE = {  # s: Cauchy stress sigma_33 [Pa] at the default snow, J_P unbounded
    0.99: -1556, 0.975: -3889, 0.95: -5158, 0.9: -9092, 0.85: -16077, 0.8: -28526, 0.7: -90921, 0.6: -295.8e3,
}  # fmt: skip


def answer(s, law=DEFAULT):
    """Return J_P, tau_33, tau_11 of uniaxial strain s.

    Elastic for s >= 1 - theta_c: tau_33 = M_c (s - 1) s, tau_11 = lam (s - 1) s. Below, the elastic stretch
    stays at k = 1 - theta_c, J_P = s / k, and both are those of k, multiplied by exp(xi (1 - J_P)).
    """
    k = np.maximum(s, 1 - law.theta_c)
    J_P = s / k
    h = law.hardening(J_P)
    return J_P, h * law.M_c * (k - 1) * k, h * law.lam0 * (k - 1) * k


def test_material_point_in_one_step():
    """One return map from rest to s; float64's rounding through exp(xi (1 - J_P)) stays under 1e-10."""
    s = np.linspace(0.62, 0.999, 60)
    F = np.tile(np.eye(3), (len(s), 1, 1))
    F[:, 2, 2] = s
    _, J_P, tau, _ = respond(_core.f64, F, 1.0, DEFAULT)
    expected = answer(s)
    np.testing.assert_allclose(J_P, expected[0], rtol=1e-10)
    np.testing.assert_allclose(tau[:, 2, 2], expected[1], rtol=1e-10)
    np.testing.assert_allclose(tau[:, 0, 0], expected[2], rtol=1e-10)


def test_material_point_in_many_steps():
    """The path does not matter: 400 small steps to s = 0.7 end where one does. 400 roundings: 1e-10."""
    s = np.linspace(1.0, 0.7, 401)
    F_E, J_P = np.eye(3)[None], np.ones(1)
    for before, after in pairwise(s):
        F_E, J_P, tau, _ = respond(_core.f64, np.diag([1, 1, after / before]) @ F_E, J_P, DEFAULT)
    expected = answer(0.7)
    np.testing.assert_allclose([J_P[0], tau[0, 2, 2], tau[0, 0, 0]], expected, rtol=1e-10)


def test_table():
    """The Cauchy stress sigma = tau / s in whole pascals (four digits below s = 0.65)."""
    for s, sigma in TABLE.items():
        assert answer(s)[1] / s == pytest.approx(sigma, abs=0.6 if s > 0.65 else 60)


def test_bar(spline, lively_transfer):
    """Snow confined by its own inertia: v_z = -rate z in a block, read in the middle before its edges tell.

    z = (1 - rate t) Z is an exact solution: the stress is even, so nothing is accelerated. Free edges end it,
    but their news travels at the wave speed, at most sqrt(h M_c / rho) = 29 m/s for the hardening h of s =
    0.9, which comes after 8.3 ms: 0.24 m, and the middle four cells are 0.35 m from the edge. What is left
    is noise: particles in jittered places leave sum V0 grad w = 0 to a few percent only. dv = dt sum V0 tau
    grad w / m strains neighbours by up to (c t / dx)^2 of a few percent of the stress, averaged over 500
    particles: 1 %.
    """
    half, dx, rate, dt = 0.45, 0.05, 12.0, 1e-4
    block = box(size=(2 * half, 2 * half, 2 * half))
    numerics = {
        "spline": spline,
        "transfer": lively_transfer,
        "dx": dx,
        "dt": dt,
        "initial_volume": "sampled",
    }
    sim = simulate(scene([block], precision="float32", **numerics))
    sim.state.v[:, 2] = -rate * np.asarray(sim.state.x)[:, 2]
    sim.state.C[:, 2, 2] = -rate
    for target in (0.98, 0.95, 0.9):
        march(sim, round((1 - target) / rate / dt) - sim.steps)
        s = 1 - rate * sim.time
        p, _ = oracle(sim)
        middle = (np.abs(p.x) < 2 * dx).all(1)
        tau = snow.kirchhoff(p.F_E, p.J_P, p.law)[middle].mean(0)
        J_P, tau_33, tau_11 = answer(s)
        assert p.J_P[middle].mean() == pytest.approx(J_P, rel=0.001), s
        assert tau[2, 2] == pytest.approx(tau_33, rel=0.03), s
        assert tau[0, 0] == pytest.approx(tau_11, rel=0.03), s
        assert tau[1, 1] == pytest.approx(tau_11, rel=0.03), s
