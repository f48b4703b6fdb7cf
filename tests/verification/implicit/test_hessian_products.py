"""Second derivatives of every law: against differences of the stress, symmetric, and projected."""

import numpy as np
import pytest
from reference.laws import unyielding
from verification.material import near_identity, parameters, respond, transpose

from neve import _core

TURNS = np.linalg.qr(np.random.default_rng(5).standard_normal((2, 3, 3)))[0]
TURNS *= np.sign(np.linalg.det(TURNS))[:, None, None]
STRETCHES = {
    "equal": (1.0, 1.0, 1.0),
    "two equal": (1.02, 1.02, 0.99),
    "nearly equal": (1.02, 1.02 * (1 + 1e-9), 0.97),
    "pressed": (0.9, 0.9, 0.9),
    "apart": (1.3, 1.0, 0.7),
}


def hessian(law, F, dF, project=False, J_P=1.0):
    """DP (n, 3, 3) [Pa] of F and dF (n, 3, 3) in float64."""
    elastic = unyielding(law)
    J = np.broadcast_to(np.float64(J_P), len(F)).copy()
    return _core.f64.hessian_product(elastic.law, elastic.plasticity, parameters(elastic), F, J, dF, project)


def stress(law, F, J_P=1.0):
    """P = tau F^-T (n, 3, 3) [Pa]."""
    return respond(_core.f64, F, J_P, unyielding(law))[2] @ transpose(np.linalg.inv(F))


def differences(law, F, dF, h=1e-3, J_P=1.0):
    """DP by central differences of order 6 in h: error h^6 times the seventh derivative, and eps / h."""
    at = [stress(law, F + k * h * dF, J_P) - stress(law, F - k * h * dF, J_P) for k in (1, 2, 3)]
    return (45 * at[0] - 9 * at[1] + at[2]) / (60 * h)


def directions(n, seed=3):
    """Return (n, 3, 3) of unit size."""
    d = np.random.default_rng(seed).standard_normal((n, 3, 3))
    return d / np.linalg.norm(d, axis=(1, 2))[:, None, None]


def test_the_product_is_the_derivative_of_the_stress(law):
    """Of 200 random F with strains of 0.1, to 1e-8 M_c: h^6 = 1e-18, and eps M_c / h = 2e-13 M_c.

    (Logarithms at stretches down to 0.6 have a seventh derivative of 720 / 0.6^7 = 3e4.)
    """
    J_P = 1.0 if law.law == "drucker_prager" or law.plasticity == "none" else 0.98
    F, dF = near_identity(200, 0.1), directions(200)
    found = hessian(law, F, dF, J_P=J_P)
    unit = law.M_c * np.max(law.hardening(np.array([J_P])))
    np.testing.assert_allclose(found, differences(law, F, dF, J_P=J_P), atol=1e-8 * unit, rtol=0)


@pytest.mark.parametrize("stretches", STRETCHES.values(), ids=STRETCHES)
def test_equal_stretches_have_derivatives(law, stretches):
    """Where the quotients would be 0/0: to 1e-8 M_c as above."""
    F = np.repeat((TURNS[0] @ np.diag(stretches) @ TURNS[1])[None], 20, axis=0)
    dF = directions(20)
    np.testing.assert_allclose(hessian(law, F, dF), differences(law, F, dF), atol=1e-8 * law.M_c, rtol=0)


def test_opposite_stretches_are_finite(law):
    """Of a reflection two stretches sum to zero, where fixed corotated energy has a kink: all is finite."""
    F = np.repeat((TURNS[0] @ np.diag((1.0, 0.8, -0.8)) @ TURNS[1])[None], 8, axis=0)
    assert np.isfinite(hessian(law, F, directions(8))).all()
    assert np.isfinite(hessian(law, F, directions(8), project=True)).all()


@pytest.mark.parametrize("project", [False, True])
def test_the_product_is_symmetric(law, project):
    """a : H b = b : H a to 1e-13 of their sizes."""
    F, a, b = near_identity(200, 0.2, seed=8), directions(200, 1), directions(200, 2)
    left, right = (np.sum(x * hessian(law, F, y, project), axis=(1, 2)) for x, y in ((a, b), (b, a)))
    np.testing.assert_allclose(left, right, atol=1e-12 * law.M_c, rtol=0)


def matrices(law, F, project):
    """H as (n, 9, 9)."""
    units = np.eye(9).reshape(9, 3, 3)
    columns = [hessian(law, F, np.repeat(d[None], len(F), axis=0), project).reshape(-1, 9) for d in units]
    return np.stack(columns, axis=2)


def test_projection_changes_only_what_is_indefinite(law):
    """The eigenvalues become those of the raw product with zeros for the negative ones; positive ones stay.

    Pressed snow has negative ones; snow pulled evenly by a thousandth has none under corotated or logarithmic
    energy, and there the product stays the same to the bit.
    """
    F = near_identity(100, 0.15, seed=6)
    raw, projected = matrices(law, F, False), matrices(law, F, True)
    before, after = np.linalg.eigvalsh(raw), np.linalg.eigvalsh(projected)
    assert (before.min(axis=1) < 0).any()
    np.testing.assert_allclose(after, np.sort(np.maximum(before, 0), axis=1), atol=1e-10 * law.M_c, rtol=0)
    even = np.repeat(1.001 * TURNS[:1], 4, axis=0)
    np.testing.assert_array_equal(matrices(law, even, False), matrices(law, even, True))
