"""The modulus that a law reports is rho0 c^2 of its fastest wave, from the acoustic tensor."""

import numpy as np
import pytest
from reference.laws import LAWS, unyielding
from verification.material import near_identity, respond, response, transpose

from neve import _core
from neve.scene.values import choices


def tangent(F, J_P, law, h=1e-5):
    """dP_iJ / dF_kL of the core by central differences [Pa] (n, 3, 3, 3, 3)."""

    def P(F):
        return respond(_core.f64, F, J_P, law)[2] @ transpose(np.linalg.inv(F))

    A = np.empty((*F.shape, 3, 3))
    for k in range(3):
        for m in range(3):
            d = np.zeros((3, 3))
            d[k, m] = h
            A[..., k, m] = (P(F + d) - P(F - d)) / (2 * h)
    return A


def fastest(A, F, n):
    """Largest rho0 c^2 [Pa] (n,) of waves along n (n, 3): Q_ik = A_iJkL N_J N_L with N = F^T n."""
    N = np.einsum("pij,pi->pj", F, n)
    Q = np.einsum("piJkL,pJ,pL->pik", A, N, N)
    return np.linalg.eigvalsh(0.5 * (Q + transpose(Q)))[:, -1]


@pytest.mark.parametrize("name", [name for name in LAWS if "alone" not in name])
@pytest.mark.parametrize("spread", [0.02, 0.15])
def test_modulus_is_the_largest_of_the_acoustic_tensor(name, spread):
    """Over the principal axes it is that of finite differences; other directions are not faster.

    Differences of tau with h = 1e-5: truncation h^2 C''/6 ~ 1e-10, rounding 60 eps / h ~ 1e-9, so 1e-7.
    That the axes are extreme is exact for fixed corotated and neo-Hookean elasticity (see their headers); for
    Hencky's it is found to hold to 1e-3 at these strains (0.6 % at strains of 0.25). Hardened: J_P below one,
    for the laws whose elasticity hardens.
    """
    law = unyielding(LAWS[name])
    rng = np.random.default_rng(3)
    F = near_identity(60, spread, seed=2)
    modulus = response(_core.f64, F, 1.0, law)[4]
    A = tangent(F, 1.0, law)
    U = np.linalg.svd(F)[0]
    axes = np.max([fastest(A, F, U[:, :, k]) for k in range(3)], axis=0)
    np.testing.assert_allclose(axes, modulus, rtol=1e-7)
    for n in rng.standard_normal((200, len(F), 3)):
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        assert (fastest(A, F, n) <= modulus * (1 + (1e-3 if spread > 0.1 else 1e-6))).all()


def test_hardened_snow_reports_its_hardened_modulus(law):
    """At J_P = 0.95 it is h(J_P) times that at J_P = 1 of the same F_E; h = 1 for laws that do not harden.

    Rounding of exp in float64, which the oracle's h shares: 1e-14 x xi.
    """
    F = np.tile(
        np.diag([0.999, 1.001, 1.0]) if choices.LAWS[law.law].has_elastic_option else np.eye(3), (2, 1, 1)
    )
    J_P = np.array([1.0, 1.0 if law.law == "drucker_prager" or law.plasticity == "none" else 0.95])
    modulus = response(_core.f64, F, J_P, law)[4]
    assert modulus[1] / modulus[0] == pytest.approx(
        float(law.hardening(0.95)) if J_P[1] < 1 else 1.0, rel=1e-12
    )
    assert modulus[0] == pytest.approx(law.M_c, rel=0.01)
