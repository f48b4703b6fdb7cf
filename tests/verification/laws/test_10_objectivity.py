"""Known answer 10: a turned observer sees a turned stress and the same energy."""

import numpy as np
from verification.material import near_identity, respond, transpose, turns


def test_objectivity(core, precision, eps, law):
    """Psi(Q F) = Psi(F), tau(Q F) = Q tau(F) Q^T, F_E(Q F) = Q F_E(F), tau symmetric; with plastic flow.

    Q, F and Q F carry eps/2 a number, their product sums three: about 3 eps in a stretch, M_c h(J_P) times
    that in tau, and a few times more through the return map, where J_P moves by 3 x 3 eps and h by xi times
    that. Laws with a yield surface bring two states no further apart.
    """
    F, Q = near_identity(300, 0.03, seed=6).astype(precision), turns(300, seed=7)
    F_E, J_P, tau, psi = respond(core, F, 1.0, law, precision)
    F_E_Q, J_P_Q, tau_Q, psi_Q = respond(core, Q @ F, 1.0, law, precision)
    scale = law.M_c * law.hardening(J_P)
    np.testing.assert_allclose(F_E_Q, Q @ F_E, atol=30 * eps, rtol=0)
    np.testing.assert_allclose(J_P_Q, J_P, atol=30 * eps, rtol=0)
    np.testing.assert_allclose(psi_Q / scale, psi / scale, atol=10 * eps, rtol=0)
    unit = scale[:, None, None]
    np.testing.assert_allclose(tau_Q / unit, Q @ tau @ transpose(Q) / unit, atol=60 * eps, rtol=0)
    np.testing.assert_allclose(tau / unit, transpose(tau) / unit, atol=4 * eps, rtol=0)
