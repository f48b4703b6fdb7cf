"""Why [snow] limits xi theta: the work of crushing must pay for the energy that hardening adds."""

import numpy as np
import pytest
from reference.snow import Snow
from verification.material import respond

from neve import _core
from neve.scene.values.choices import DEFAULT_LAW, LAWS

THETA, STEP = 1e-2, 1e-6
MOST_HARDENING = LAWS[DEFAULT_LAW].most_strength(
    {"xi": 1.0, "theta_c": 1.0, "theta_s": 0.0}
)  # largest xi theta


def gain_over_work(xi, nu):
    """Crush snow at its limit 1 - theta by STEP more along all axes: energy gained over work done [1]."""
    law = Snow(xi=xi, nu=nu, theta_c=THETA, theta_s=THETA)
    s = 1.0 - THETA
    F = np.stack([s * np.eye(3), s * (1.0 - STEP) * np.eye(3)])
    _, J_P, tau, psi = respond(_core.f64, F, 1.0, law)
    np.testing.assert_allclose(J_P, [1.0, (1.0 - STEP) ** 3], rtol=1e-12)
    work = -np.trace(tau[0]) * STEP
    return (psi[1] - psi[0]) / work


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.45])
def test_work_pays_for_hardening(nu):
    """gain / work = 3/2 xi theta to first order in theta: 0.75 at the limit of [snow], 1 at xi theta = 2/3.

    Psi = (3 mu + 9/2 lam) theta^2 grows by the factor 3 xi d eps, the work is 3 (2 mu + 3 lam) theta d eps.
    The next order is a share of theta where mu is alone (work 6 mu theta (1 - theta) d eps), and of 2 theta
    where lam is (3 lam (1 - j) j d eps with j = (1 - theta)^3, Psi = lam (1 - j)^2 / 2); 4 theta leaves room
    for theta^2.
    """
    at_limit = gain_over_work(MOST_HARDENING / THETA, nu)
    assert at_limit == pytest.approx(1.5 * MOST_HARDENING, rel=4 * THETA)
    assert at_limit < 1.0 < gain_over_work(1.4 * MOST_HARDENING / THETA, nu)
