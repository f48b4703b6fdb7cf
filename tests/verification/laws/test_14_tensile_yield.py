"""Known answer 14: pulled snow yields at M_c theta_s (1 + theta_s) and softens from there."""

import numpy as np
import pytest
from verification.material import DEFAULT, respond

from neve import _core


def pull(stretch):
    """Pull to the total uniaxial stretch (n,) in one go; returns J_P and tau_33 in float64."""
    F = np.tile(np.eye(3), (len(stretch), 1, 1))
    F[:, 2, 2] = stretch
    _, J_P, tau, _ = respond(_core.f64, F, 1.0, DEFAULT)
    return J_P, tau[:, 2, 2]


def test_tensile_yield():
    """tau_33 = M_c (s - 1) s up to s = 1 + theta_s = 1.0075, where it is 1175.4 Pa.

    1e-10 is float64's rounding.
    """
    J_P, tau = pull(np.array([1.002, 1.005, 1.0 + DEFAULT.theta_s]))
    s = np.array([1.002, 1.005, 1.0075])
    np.testing.assert_allclose(tau, DEFAULT.M_c * (s - 1) * s, rtol=1e-10)
    np.testing.assert_allclose(J_P, 1, rtol=1e-12)
    assert tau[-1] == pytest.approx(1175.4, abs=0.05)


def test_softening():
    """Beyond it J_P = s / (1 + theta_s) > 1 and tau_33 = exp(xi (1 - J_P)) 1175.4 Pa, which only falls."""
    s = np.linspace(1.01, 1.5, 50)
    J_P, tau = pull(s)
    top = 1 + DEFAULT.theta_s
    np.testing.assert_allclose(J_P, s / top, rtol=1e-12)
    expected = np.exp(DEFAULT.xi * (1 - s / top)) * DEFAULT.M_c * DEFAULT.theta_s * top
    np.testing.assert_allclose(tau, expected, rtol=1e-10)
    assert (np.diff(tau) < 0).all()


def test_plateau_without_hardening():
    """With xi = 0 the stress stays at the plateau to 1e-10, however far the snow is drawn."""
    from reference.snow import Snow

    law = Snow(xi=0.0)
    F = np.tile(np.eye(3), (20, 1, 1))
    F[:, 2, 2] = np.linspace(1.01, 3, 20)
    tau = respond(_core.f64, F, 1.0, law)[2][:, 2, 2]
    np.testing.assert_allclose(tau, law.M_c * law.theta_s * (1 + law.theta_s), rtol=1e-10)
