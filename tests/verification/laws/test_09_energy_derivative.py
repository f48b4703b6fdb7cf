"""Known answer 9: the stress of every law is the derivative of its energy, and is the oracle's."""

from dataclasses import replace

import numpy as np
from reference import snow
from reference.laws import unyielding
from verification.material import LAPACK, near_identity, respond, transpose

from neve import _core


def test_stress_is_the_derivative_of_energy(law):
    """P = dPsi/dF, tau = P F^T, by central differences with h = 1e-5 in float64, where nothing yields.

    Truncation h^2/6 times the third derivative < 1e-9 M_c (stretches down to 0.6 in the logarithms
    included), rounding eps Psi / h < 1e-12 M_c: together below 1e-7 M_c with room for the third derivative's
    size when two stretches of opposite sign nearly cancel (spread 0.1 keeps them apart). drucker_prager is at
    its only elastic J_P, 1.
    """
    J_P = 1.0 if law.law == "drucker_prager" or law.plasticity == "none" else np.linspace(0.9, 1.1, 50)
    F, h, elastic = near_identity(50, 0.1), 1e-5, unyielding(law)
    P = np.empty_like(F)
    for i in range(3):
        for j in range(3):
            d = np.zeros((3, 3))
            d[i, j] = h
            ahead, behind = (respond(_core.f64, F + s * d, J_P, elastic)[3] for s in (1, -1))
            P[:, i, j] = (ahead - behind) / (2 * h)
    F_E, _, tau, _ = respond(_core.f64, F, J_P, elastic)
    np.testing.assert_array_equal(F_E, F)
    np.testing.assert_allclose(P @ transpose(F), tau, atol=1e-7 * law.M_c, rtol=0)


def test_both_precisions_agree(core, precision, eps, law):
    """F_E, J_P, tau and psi equal the oracle's: 30 eps of this precision and what float64's LAPACK adds.

    F carries eps/2, so each stretch does; tau = M_c (s - 1) s amplifies that by M_c, twice through F - R and
    J - 1, and the decomposition adds its own few eps. 30 eps M_c h(J_P) is far below the yield stress M_c
    theta_c. A projection onto a convex yield surface brings two states closer, never apart.
    """
    F = near_identity(500, 0.02, seed=4).astype(precision)
    J_P = np.linspace(0.97, 1.03, 500).astype(precision) if law.plasticity == "snow" else np.ones(500)
    F_E, J_P_new, tau, psi = respond(core, F, J_P, law, precision)
    F_E_64, J_P_64 = snow.return_map(F.astype(float), J_P.astype(float), law)
    tau_64, psi_64 = snow.kirchhoff(F_E_64, J_P_64, law), snow.energy(F_E_64, J_P_64, law)
    unit, tolerance = law.M_c * law.hardening(J_P_64), 30 * eps + LAPACK
    np.testing.assert_allclose(F_E, F_E_64, atol=tolerance, rtol=0)
    np.testing.assert_allclose(J_P_new, J_P_64, rtol=tolerance)
    np.testing.assert_allclose((tau - tau_64) / unit[:, None, None], 0, atol=tolerance)
    np.testing.assert_allclose((psi - psi_64) / unit, 0, atol=0.1 * tolerance)


def test_strength_is_a_factor_on_the_thresholds(core, precision, eps, law):
    """Per particle 0.25 to 4 times theta_c and theta_s, cohesion, p0: the oracle's, 30 eps as above."""
    law = replace(law, strength=np.geomspace(0.25, 4, 300).astype(precision).astype(float))
    F = near_identity(300, 0.02, seed=14).astype(precision)
    F_E, J_P, tau, _ = respond(core, F, 1.0, law, precision)
    F_E_64, J_P_64 = snow.return_map(F.astype(float), np.ones(300), law)
    unit = law.M_c * law.hardening(J_P_64)
    np.testing.assert_allclose(F_E, F_E_64, atol=30 * eps + LAPACK, rtol=0)
    np.testing.assert_allclose(J_P, J_P_64, rtol=30 * eps + LAPACK)
    error = (tau - snow.kirchhoff(F_E_64, J_P_64, law)) / unit[:, None, None]
    np.testing.assert_allclose(error, 0, atol=30 * eps + LAPACK)


def test_small_strains_keep_their_digits(core, precision, eps, law):
    """At a strain of 1e-5 a law loses 4 eps of M_c at most, where eps/2 is what F itself can hold.

    F is rounded first and the answer taken from the rounded F, so what is tested is the law's own arithmetic.
    """
    F = near_identity(200, 1e-5, seed=5).astype(precision)
    elastic = unyielding(law)
    tau = respond(core, F, 1.0, elastic, precision)[2]
    exact = snow.kirchhoff(F.astype(float), np.ones(len(F)), elastic)
    np.testing.assert_allclose(tau, exact, atol=(4 * eps + LAPACK) * law.M_c, rtol=0)
