"""Known answers 13 and 14 for every law: the curve of uniaxial strain, pressed and pulled, at one point."""

from dataclasses import replace

import numpy as np
import pytest
from reference.laws import CLAY, LAWS, SAND
from reference.snow import Snow
from verification.material import respond

from neve import _core

ELASTIC = {  # tau_33 and tau_11 of diag(1, 1, s) without flow
    "stomakhin2013": lambda s, mu, lam: ((2 * mu + lam) * (s - 1) * s, lam * (s - 1) * s),
    "neo_hookean": lambda s, mu, lam: (mu * (s**2 - 1) + lam * np.log(s), lam * np.log(s)),
    "hencky": lambda s, mu, lam: ((2 * mu + lam) * np.log(s), lam * np.log(s)),
}
TABLE = {  # tau_33 [Pa] at s = 0.975 and 0.5, default constants, elasticity alone
    "stomakhin2013": (-3791.7, -38889),
    "neo_hookean": (-3864.8, -70706),
    "hencky": (-3938.3, -107823),
}


def uniaxial(s):
    F = np.tile(np.eye(3), (len(s), 1, 1))
    F[:, 2, 2] = s
    return F


def at_once(s, law):
    """J_P, tau_33 and tau_11 after one return map from rest to the stretches s (n,)."""
    _, J_P, tau, _ = respond(_core.f64, uniaxial(s), 1.0, law)
    return J_P, tau[:, 2, 2], tau[:, 0, 0]


@pytest.mark.parametrize("name", TABLE)
def test_table_of_elasticities(name):
    """The stress of three elasticities at two compressions, in the digits of the table."""
    _, tau, _ = at_once(np.array([0.975, 0.5]), LAWS[f"{name} alone"])
    assert tau[0] == pytest.approx(TABLE[name][0], abs=0.06)
    assert tau[1] == pytest.approx(TABLE[name][1], abs=0.6)


@pytest.mark.parametrize("name", ELASTIC)
def test_snow_plasticity_over_each_elasticity(name):
    """The elastic stretch k stays in [1 - theta_c, 1 + theta_s]; J_P = s / k; h(J_P) times the stress of k.

    Float64's rounding through exp(xi (1 - J_P)): 1e-10.
    """
    law, s = LAWS[name], np.concatenate([np.linspace(0.62, 0.999, 60), np.linspace(1.001, 1.5, 60)])
    k = np.clip(s, 1 - law.theta_c, 1 + law.theta_s)
    h = law.hardening(s / k)
    answer = ELASTIC[name](k, h * law.mu0, h * law.lam0)
    J_P, tau_33, tau_11 = at_once(s, law)
    np.testing.assert_allclose(J_P, s / k, rtol=1e-12)
    np.testing.assert_allclose(tau_33, answer[0], rtol=1e-10)
    np.testing.assert_allclose(tau_11, answer[1], rtol=1e-10)


def test_elasticities_agree_at_the_clamp():
    """The same linearisation: at the critical strains they differ by O(theta), 4 % and 1 %.

    tau_33 / M_c at s = 1 + e: e + e^2 (fixed corotated), e + (2 mu - lam) e^2 / (2 M_c) (neo-Hookean),
    e - e^2 / 2 (Hencky): apart by 1.5 e at the most.
    """
    for e in (-0.025, 0.0075):
        tau = [at_once(np.array([1 + e]), LAWS[f"{name} alone"])[1][0] for name in ELASTIC]
        assert max(tau) / min(tau) == pytest.approx(1, abs=1.6 * abs(e))
        np.testing.assert_allclose(np.array(tau) / Snow().M_c, e, rtol=1.1 * abs(e))


@pytest.mark.parametrize("name", ["drucker_prager", "drucker_prager cohesive"])
def test_confined_sand(name):
    """p = -K ln s as if it were elastic, q = min(2 mu |ln s|, M_phi (p + p_t)); tau_33 = -p -+ 2 q / 3.

    Pulled: the same until the apex, where only p = -p_t is left. Float64: 1e-10 of M_c.
    """
    law, s = LAWS[name], np.concatenate([np.linspace(0.5, 0.999, 50), np.linspace(1.0001, 1.3, 50)])
    phi = np.radians(law.friction_angle)
    p_t = law.cohesion / np.tan(phi)
    p = np.maximum(-law.K * np.log(s), -p_t)
    q = np.minimum(2 * law.mu0 * np.abs(np.log(s)), 6 * np.sin(phi) / (3 - np.sin(phi)) * (p + p_t))
    J_P, tau_33, tau_11 = at_once(s, law)
    side = np.sign(np.log(s))
    np.testing.assert_allclose(tau_33, -p + side * 2 * q / 3, atol=1e-10 * law.M_c, rtol=0)
    np.testing.assert_allclose(tau_11, -p - side * q / 3, atol=1e-10 * law.M_c, rtol=0)
    np.testing.assert_allclose(J_P, np.maximum(s / np.exp(p_t / law.K), 1), rtol=1e-12)


def confined_clay(law, eta_end, n):
    """p, q, J_P of cam_clay at uniaxial compression eta = -ln s: its equations of rate, by Runge-Kutta.

    dp = K (d eta - L y_p), dq = 3 mu (2/3 d eta - L y_q), d ln J_P = -L y_p, and y = 0 along the way gives
    the multiplier L = (K y_p + 2 mu y_q) / (K y_p^2 + 3 mu y_q^2 + y_p0 dp0/dlnJ_P y_p) d eta.
    """
    K, mu = law.K, law.mu0

    def p0_of(ln_J_P):
        w = np.arcsinh(law.p0 / K) - law.xi * ln_J_P
        return K * np.sinh(w), -K * law.xi * np.cosh(w)

    def rates(u):
        p, q, ln_J_P = u
        p0, slope = p0_of(ln_J_P)
        y_p = law.M**2 * (2 * p - (1 - law.beta) * p0)
        y_q = 2 * (1 + 2 * law.beta) * q
        y_p0 = law.M**2 * (-(1 - law.beta) * p - 2 * law.beta * p0)
        flow = (K * y_p + 2 * mu * y_q) / (K * y_p**2 + 3 * mu * y_q**2 + y_p0 * slope * y_p)
        return np.array([K * (1 - flow * y_p), 3 * mu * (2 / 3 - flow * y_q), -flow * y_p])

    # elastic: p = K eta, q = 2 mu eta, until (1 + 2 beta) q^2 + M^2 (p + beta p0) (p - p0) = 0
    a = (1 + 2 * law.beta) * 4 * mu**2 + law.M**2 * K**2
    b = law.M**2 * K * law.p0 * (law.beta - 1)
    eta = (-b + np.sqrt(b**2 + 4 * a * law.M**2 * law.beta * law.p0**2)) / (2 * a)
    u, step = np.array([K * eta, 2 * mu * eta, 0.0]), (eta_end - eta) / n
    for _ in range(n):
        k1 = rates(u)
        k2 = rates(u + step / 2 * k1)
        k3 = rates(u + step / 2 * k2)
        u = u + step / 6 * (k1 + 2 * k2 + 2 * k3 + rates(u + step * k3))
    return u[0], u[1], np.exp(u[2])


def core_clay(law, eta_end, n):
    """p, q and J_P of the core after n equal steps of the same path."""
    F_E, J_P = np.eye(3)[None], np.ones(1)
    for _ in range(n):
        F_E, J_P, tau, _ = respond(_core.f64, np.diag([1, 1, np.exp(-eta_end / n)]) @ F_E, J_P, law)
    return -np.trace(tau[0]) / 3, tau[0, 0, 0] - tau[0, 2, 2], J_P[0]


@pytest.mark.parametrize(
    "law", [CLAY, LAWS["cam_clay cohesive"], replace(CLAY, xi=10.0)], ids=["I", "II", "hard"]
)
def test_oedometer_of_cam_clay(law):
    """Pressed to s = exp(-0.1): the core in n steps converges to the integrated rates with order one.

    p0 is that of the step's start, so the error is first order: halving the step halves it (1.7 to 2.3), and
    at 800 steps it is below 1 % of p. Runge-Kutta of order four on 4000 steps is exact to 1e-8 beside it.
    """
    exact = np.array(confined_clay(law, 0.1, 4000))
    errors = [np.abs(np.array(core_clay(law, 0.1, n)) / exact - 1) for n in (400, 800)]
    assert exact[2] < 0.99
    assert (errors[1] < 0.01).all()
    assert 1.7 < errors[0][0] / errors[1][0] < 2.3


@pytest.mark.parametrize("beta", [0.0, 0.3])
def test_pulled_clay_softens_to_nothing(beta):
    """Pulled by 5 % in 400 steps, cam_clay's tension stays small and falls to what the floor leaves.

    The tip of the ellipse allows beta p0 on each axis, a step adds less than M_c times its strain. Softening
    is over when -alpha is spent: J_P = exp(asinh(p0 / K) / xi) = 1.0012 for p0 = 3 kPa. Then p0 = 1e-6 K.
    """
    law = replace(CLAY, beta=beta)
    F_E, J_P, peak = np.eye(3)[None], np.ones(1), 0.0
    for _ in range(400):
        F_E, J_P, tau, _ = respond(_core.f64, np.diag([1, 1, np.exp(0.05 / 400)]) @ F_E, J_P, law)
        peak = max(peak, tau[0, 2, 2])
    assert np.abs(tau).max() <= 3 * 1e-6 * law.K
    assert peak <= 3 * beta * law.p0 + law.M_c * 0.05 / 400
    assert peak > 0.3 * beta * law.p0
    assert J_P[0] == pytest.approx(np.exp(0.05), rel=2e-3)


def test_sand_and_snow_differ_only_beyond_the_yield():
    """With the same E0 and nu, Hencky's laws are one until they flow: pressed by 1e-4, to rounding."""
    constants = {"E0": 1e6, "nu": 0.25}
    snows = [
        replace(law, **constants) for law in (LAWS["hencky"], SAND, replace(CLAY, p0=1e5, M=2.0, beta=1.0))
    ]
    F = np.exp(-1e-4) * np.eye(3)[None]
    tau = [respond(_core.f64, F, 1.0, law)[2] for law in snows]
    np.testing.assert_allclose(tau[1], tau[0], rtol=1e-11)
    np.testing.assert_allclose(tau[2], tau[0], rtol=1e-11)
