"""Known answer 9: the stress of the core is the derivative of its energy."""

import numpy as np
from reference import snow
from verification.material import DEFAULT, ELASTIC, LAPACK, near_identity, respond, transpose

from neve import _core


def test_stress_is_the_derivative_of_energy():
    """P = dPsi/dF, tau = P F^T, by central differences with h = 1e-5 in float64.

    Truncation h^2/6 Psi''' < 1e-9 M_c, rounding eps Psi / h < 1e-12 M_c: together below 1e-7 M_c with room
    for the third derivative's size when two stretches of opposite sign nearly cancel (spread 0.1 keeps them
    apart).
    """
    F, J_P, h = near_identity(50, 0.1), np.linspace(0.9, 1.1, 50), 1e-5
    P = np.empty_like(F)
    for i in range(3):
        for j in range(3):
            d = np.zeros((3, 3))
            d[i, j] = h
            ahead, behind = (respond(_core.f64, F + s * d, J_P, ELASTIC)[3] for s in (1, -1))
            P[:, i, j] = (ahead - behind) / (2 * h)
    tau = respond(_core.f64, F, J_P, ELASTIC)[2]
    np.testing.assert_allclose(P @ transpose(F), tau, atol=1e-7 * ELASTIC.M_c, rtol=0)


def test_both_precisions_agree(core, precision, eps):
    """F_E, J_P, tau and psi equal the oracle's: 30 eps of this precision and what float64's LAPACK adds.

    F carries eps/2, so each stretch does; tau = M_c (s - 1) s amplifies that by M_c, twice through F - R and
    J - 1, and the decomposition adds its own few eps. 30 eps M_c h(J_P) is far below the yield stress M_c
    theta_c.
    """
    F = near_identity(500, 0.02, seed=4).astype(precision)
    J_P = np.linspace(0.97, 1.03, 500).astype(precision)
    F_E, J_P_new, tau, psi = respond(core, F, J_P, DEFAULT, precision)
    F_E_64, J_P_64 = snow.return_map(F.astype(float), J_P.astype(float), DEFAULT)
    tau_64, psi_64 = snow.kirchhoff(F_E_64, J_P_64, DEFAULT), snow.energy(F_E_64, J_P_64, DEFAULT)
    unit, tolerance = DEFAULT.M_c * DEFAULT.hardening(J_P_64), 30 * eps + LAPACK
    np.testing.assert_allclose(F_E, F_E_64, atol=tolerance, rtol=0)
    np.testing.assert_allclose(J_P_new, J_P_64, rtol=tolerance)
    np.testing.assert_allclose((tau - tau_64) / unit[:, None, None], 0, atol=tolerance)
    np.testing.assert_allclose((psi - psi_64) / unit, 0, atol=0.1 * tolerance)


def test_small_strains_keep_their_digits(core, precision, eps):
    """At a strain of 1e-5 the law loses 4 eps of the strain at most, where eps/2 is what F itself can hold.

    F is rounded first and the answer taken from the rounded F, so what is tested is the law's own arithmetic.
    """
    F = near_identity(200, 1e-5, seed=5).astype(precision)
    tau = respond(core, F, 1.0, ELASTIC, precision)[2]
    exact = snow.kirchhoff(F.astype(float), np.ones(len(F)), ELASTIC)
    np.testing.assert_allclose(tau, exact, atol=(4 * eps + LAPACK) * ELASTIC.M_c, rtol=0)
