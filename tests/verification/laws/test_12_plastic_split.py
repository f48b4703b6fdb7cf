"""Known answer 12: a return map moves deformation from F_E to F_P and loses none."""

import numpy as np
from reference.snow import Snow
from verification.material import DEFAULT, near_identity, respond, response, transpose, turns


def test_volume_is_conserved(core, precision, eps, law):
    """J_E J_P = det F_trial J_P_0 for every law, whatever flows: three stretches of a few eps each, 30 eps.

    With J_P_0 between 0.9 and 1.1 the stretches of drucker_prager take J_P back.
    """
    alone = law.plasticity == "none"
    F = near_identity(2000, 0.05, seed=18).astype(precision)
    J_P_0 = np.linspace(1.0 if alone else 0.9, 1.0 if alone else 1.1, len(F)).astype(precision)
    F_E, J_P, _, _ = respond(core, F, J_P_0, law, precision)
    before = np.linalg.det(F.astype(float)) * J_P_0.astype(float)
    np.testing.assert_allclose(np.linalg.det(F_E) * J_P, before, rtol=0, atol=30 * eps)
    assert (np.abs(J_P - J_P_0) > 1e-3).any() != alone


def test_companions_do_not_matter(core, precision, eps, law):
    """A particle flows the same in any company of its pack: to 30 eps, the rounding of the SVD's sweeps."""
    F = near_identity(500, 0.03, seed=19).astype(precision)
    order = np.random.default_rng(20).permutation(len(F))
    F_E, J_P, tau, psi = respond(core, F, 1.0, law, precision)
    unit = (law.M_c * law.hardening(J_P))[order]
    other = respond(core, F[order], 1.0, law, precision)
    np.testing.assert_allclose(other[0], F_E[order], atol=30 * eps, rtol=0)
    np.testing.assert_allclose(other[1], J_P[order], rtol=30 * eps)
    np.testing.assert_allclose((other[2] - tau[order]) / unit[:, None, None], 0, atol=30 * eps)
    np.testing.assert_allclose((other[3] - psi[order]) / unit, 0, atol=3 * eps)


def test_plastic_split(core, precision, eps):
    """sigma(F_E) in [1 - theta_c, 1 + theta_s], J_E J_P = det F, F_P = F_E^-1 F_trial is symmetric.

    F_trial = U Sigma V^T and F_E = U clamp(Sigma) V^T give F_E^-1 F_trial = V (Sigma / clamp) V^T,
    symmetric. The stretches carry a few eps each and det multiplies three of them: 30 eps.
    """
    F = near_identity(2000, 0.05, seed=8).astype(precision)
    F_E, J_P, _, _ = respond(core, F, 1.0, DEFAULT, precision)
    sigma = np.linalg.svd(F_E, compute_uv=False)
    assert sigma.max() <= 1 + DEFAULT.theta_s + 10 * eps
    assert sigma.min() >= 1 - DEFAULT.theta_c - 10 * eps
    F = F.astype(float)
    np.testing.assert_allclose(np.linalg.det(F_E) * J_P, np.linalg.det(F), rtol=0, atol=30 * eps)
    F_P = np.linalg.solve(F_E, F)
    np.testing.assert_allclose(F_P, transpose(F_P), atol=60 * eps)
    assert (sigma.max(1) > 1 + DEFAULT.theta_s - 10 * eps).any()
    assert (sigma.min(1) < 1 - DEFAULT.theta_c + 10 * eps).any()


def test_elastic_range_is_left_alone(core, precision, eps):
    """Inside the limits F_E is the trial and J_P does not move: to the bit for J_P, to 10 eps for F_E."""
    F = near_identity(500, 1e-3, seed=9).astype(precision)
    J_P_0 = np.asarray(0.93, precision)
    F_E, J_P, _, _ = respond(core, F, J_P_0, DEFAULT, precision)
    np.testing.assert_allclose(F_E, F, atol=10 * eps, rtol=0)
    np.testing.assert_allclose(J_P, float(J_P_0), rtol=10 * eps)


def test_idempotent(core, precision, eps, law):
    """A second return map changes nothing, to the rounding of F_E.

    clamp(clamp(sigma)) = clamp(sigma), and a point on a yield surface is its own projection: cam_clay's is
    that of the J_P at the end of the step.
    """
    F = near_identity(500, 0.05, seed=10).astype(precision)
    F_E, J_P, tau, _ = respond(core, F, 1.0, law, precision)
    again = respond(core, F_E, J_P, law, precision)
    np.testing.assert_allclose(again[0], F_E, atol=20 * eps, rtol=0)
    np.testing.assert_allclose(again[1], J_P, rtol=20 * eps)
    scale = (law.M_c * law.hardening(J_P))[:, None, None]
    unit = again[2] / (law.M_c * law.hardening(again[1]))[:, None, None]
    np.testing.assert_allclose(unit, tau / scale, atol=60 * eps)


def test_hardening_is_bounded_from_below_in_the_exponent(core, precision, eps):
    """J_P itself goes on below J_P_min = 0.6; the stress stays at exp(xi (1 - 0.6))."""
    law = Snow(xi=10.0)
    F = np.tile(np.diag([1.0, 1.0, 0.9]), (2, 1, 1))
    _, J_P, tau, _ = respond(core, F, [0.5, 0.3], law, precision)
    s = 1 - law.theta_c
    np.testing.assert_allclose(J_P, np.array([0.5, 0.3]) * 0.9 / s, rtol=30 * eps)
    expected = np.exp(law.xi * (1 - law.J_P_min)) * law.M_c * (s - 1) * s
    np.testing.assert_allclose(tau[:, 2, 2], expected, rtol=30 * eps / law.theta_c)


def test_expansion_is_bounded_in_the_state(core, precision, eps):
    """J_P stops at J_P_max = 20, where no stiffness is left: a lone grain's would grow without end."""
    F = np.tile(np.diag([1.0, 1.0, 2.0]), (2, 1, 1))
    _, J_P, tau, _ = respond(core, F, [5.0, 15.0], DEFAULT, precision)
    top = 1 + DEFAULT.theta_s
    np.testing.assert_allclose(J_P, [5 * 2 / top, 20.0], rtol=30 * eps)
    assert np.abs(tau).max() < 1e-30


def test_extremes_stay_finite(core, precision, law):
    """Stretches from 1e-8 to 1e3, flat, inverted and zero, with any J_P: numbers come out, and no NaN.

    Such steps are refused elsewhere; here only logarithms and quotients must not break down.
    """
    n, rng = 2000, np.random.default_rng(21)
    sigma = 10.0 ** rng.uniform(-8, 3, (n, 3))
    sigma[::5, 2] *= -1
    sigma[::7, 2] = 0
    sigma[:10] = 0
    J_P = 10.0 ** rng.uniform(-3, 3, n)
    J_P[::11] *= -1
    F = (turns(n, 22) * sigma[:, None, :]) @ turns(n, 23)
    for part in response(core, F, J_P, law, precision):
        assert np.isfinite(part).all()
