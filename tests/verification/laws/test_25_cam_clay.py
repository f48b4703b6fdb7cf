"""Known answer 25: cam_clay's return map ends on its ellipse, where associative flow leads, and moves it."""

from dataclasses import replace

import numpy as np
import pytest
from reference.laws import LAWS
from reference.plasticity import cam_clay_size, cam_clay_yield
from verification.material import near_identity, respond

SNOWS = [LAWS["cam_clay"], LAWS["cam_clay cohesive"], replace(LAWS["cam_clay"], M=2.5, beta=1.0, p0=1e5)]


@pytest.fixture(params=SNOWS, ids=["cohesionless", "cohesive", "strong"])
def clay(request):
    return request.param


def invariants(tau):
    """Pressure p, positive in compression, and q = sqrt(3/2) |dev tau| [Pa] (n,)."""
    p = -np.trace(tau, axis1=1, axis2=2) / 3
    return p, np.sqrt(1.5) * np.linalg.norm(tau + p[:, None, None] * np.eye(3), axis=(1, 2))


def strains(F):
    """ln J and |dev ln sigma| (n,)."""
    eps = np.log(np.linalg.svd(F)[1])
    return eps.sum(1), np.linalg.norm(eps - eps.mean(1, keepdims=True), axis=1)


def pressed(stretch, n=1):
    return np.tile(stretch * np.eye(3), (n, 1, 1))


def rounding(law, p0, eps):
    """Relative to p0: stresses are moduli times strains of a few eps, sums of three: 8 eps M_c / p0."""
    return 8 * eps * law.M_c / p0


def test_ends_on_the_ellipse(core, precision, eps, clay):
    """|y| <= 1e-9 p0^2 (float64) for what flowed, y <= the same for all; strains from 1e-4 to 0.1.

    y moves by (2 (1 + 2 beta) q + 2 M^2 p0) times the rounding of the stress, that is
    2 (M + M^2) (1 + 2 beta) rounding.
    """
    scatter = np.random.default_rng(0).standard_normal((3000, 3, 3))
    F = (np.eye(3) + np.geomspace(1e-4, 0.1, 3000)[:, None, None] * scatter).astype(precision)
    F_E, _, tau, _ = respond(core, F, 1.0, clay, precision)
    p, q = invariants(tau)
    y = cam_clay_yield(p, q, clay.p0, clay) / clay.p0**2
    slack = 2 * (clay.M + clay.M**2) * (1 + 2 * clay.beta) * rounding(clay, clay.p0, eps)
    assert slack < (1e-9 if precision == "float64" else 0.3)
    flowed = (np.asarray(F_E, precision) != F).any((1, 2))
    assert 0.2 < flowed.mean() < 1
    assert (y <= slack).all()
    assert (np.abs(y[flowed]) <= slack).all()


def test_cap_and_tip(core, precision, eps, clay):
    """Pressed on all sides it ends at (p0, 0), pulled at (-beta p0, 0); at J_P = 1 p0 is p0_ini."""
    for stretch, answer in ((0.9, 1.0), (0.97, 1.0), (1.3, -clay.beta), (1.02, -clay.beta)):
        p, q = invariants(respond(core, pressed(stretch), 1.0, clay, precision)[2])
        assert p[0] / clay.p0 == pytest.approx(answer, abs=rounding(clay, clay.p0, eps)), stretch
        assert q[0] / clay.p0 == pytest.approx(0, abs=2 * rounding(clay, clay.p0, eps))


def test_compaction_hardens_and_expansion_softens(core, precision, eps, clay):
    """p0 at J_P, read off the cap, is K sinh(asinh(p0_ini / K) - xi ln J_P) and falls with J_P to 1e-6 K.

    The exponent carries (xi + 2) eps; the rest is the rounding of the stress.
    """
    J_P = np.array([0.5, 0.7, 0.9, 1.0, 1.0 + 1e-4, 2.0])
    p, _ = invariants(respond(core, pressed(0.2, len(J_P)), J_P, clay, precision)[2])
    w = np.arcsinh(clay.p0 / clay.K) - clay.xi * np.log(np.maximum(J_P, clay.J_P_min))
    p0 = np.maximum(clay.K * np.sinh(np.maximum(w, 0)), 1e-6 * clay.K)
    np.testing.assert_allclose(p, p0, rtol=8 * eps, atol=8 * eps * clay.M_c)
    assert (np.diff(p) < 0).all()
    assert p[-1] == pytest.approx(1e-6 * clay.K, rel=1e-2 if precision == "float32" else 1e-6)
    np.testing.assert_allclose(p0, cam_clay_size(J_P, clay), rtol=1e-14)


def test_flow_is_associative(clay):
    """The plastic strain is along (dy/dp, dy/dq): its cross product with the normal vanishes.

    d eps_v = (ln J_E - ln J_trial), compression positive, works on p, d eps_s = (q_trial - q) / (3 mu) on q.
    float64: strains of 1e-2 carry 60 eps, relative 1e-12; ends near the tip lose some: 1e-9.
    """
    from neve import _core

    F = near_identity(2000, 0.02, seed=1)
    F_E, J_P, tau, _ = respond(_core.f64, F, 1.0, clay)
    (e, d), (e_trial, d_trial) = strains(F_E), strains(F)
    p, q = invariants(tau)
    volume, shear = e - e_trial, np.sqrt(2 / 3) * (d_trial - d)
    normal = clay.M**2 * (2 * p - (1 - clay.beta) * clay.p0), 2 * (1 + 2 * clay.beta) * q
    cross = volume * normal[1] - shear * normal[0]
    flowed = np.hypot(volume, shear) > 1e-4
    assert flowed.mean() > 0.5
    size = np.hypot(volume, shear)[flowed] * np.hypot(*normal)[flowed]
    np.testing.assert_allclose(cross[flowed] / size, 0, atol=1e-9)
    assert ((volume * normal[0] + shear * normal[1])[flowed] > 0).all()  # outwards
    np.testing.assert_allclose(np.log(J_P), -volume, atol=1e-13)


def test_shear_softens_loose_and_hardens_dense_snow():
    """What a return at constant p has not: pressed less than half of p0, sheared snow expands and weakens.

    Pressure 0.2 p0 or 0.8 p0, then 200 steps of pure shear at constant volume: J_P ends above or below one
    and so p0 below or above p0_ini; at the critical state p = (1 - beta) p0 / 2 the flow is all shear.
    """
    from neve import _core

    law, step = replace(LAWS["cam_clay"], xi=5.0), np.diag([1 + 5e-4, 1 / (1 + 5e-4), 1.0])
    for share, softens in ((0.2, True), (0.8, False)):
        F_E, J_P = pressed(np.exp(-share * law.p0 / law.K / 3)), np.ones(1)
        for _ in range(200):
            F_E, J_P, tau, _ = respond(_core.f64, step @ F_E, J_P, law)
        p, q = invariants(tau)
        p0 = cam_clay_size(J_P, law)
        assert (J_P[0] > 1) == softens
        assert (p0[0] < law.p0) == softens
        assert q[0] / p[0] == pytest.approx(law.M, rel=0.05)
        assert p[0] == pytest.approx(0.5 * p0[0], rel=0.1)
