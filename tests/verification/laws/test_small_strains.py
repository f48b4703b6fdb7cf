"""Snow that is proven elastic by the invariants of F F^T - I answers as snow whose stretches are known."""

import numpy as np
import pytest
from reference import snow as oracle
from reference.laws import LAWS
from verification.material import response, transpose, turns

SNOWS = [LAWS[name] for name in LAWS if LAWS[name].law in ("stomakhin2013", "neo_hookean")]
PACKS = 16 * 40


def stretched(law, share, seed):
    """Return F (n, 3, 3), turned at random, whose strains reach `share` of the thresholds."""
    rng = np.random.default_rng(seed)
    low, high = (min(a, 0.03) * share for a in (law.theta_c, law.theta_s))
    strains = rng.uniform(-low, high, (PACKS, 3))
    strains[::3, 0], strains[1::3, 1] = -low, high
    strains[::5, 1] = strains[::5, 2]
    U, V = turns(PACKS, seed + 1), turns(PACKS, seed + 2)
    return (U * (1 + strains)[:, None, :]) @ transpose(V)


@pytest.mark.parametrize("law", SNOWS, ids=lambda law: f"{law.law} {law.plasticity}")
@pytest.mark.parametrize("share", [1e-3, 0.1, 0.5, 0.999])
def test_elastic_snow_is_left_alone(core, precision, eps, law, share):
    """F_E is F to the bit, J_P stays, and tau is the oracle's, to 30 eps of a strain of one, also hardened.

    The modulus is that of the largest stretch, which is known to the third root of eps times the largest
    strain where all nearly meet.
    """
    F = stretched(law, share, seed=5).astype(precision)
    J_P = np.ones(PACKS) if law.plasticity == "none" else np.linspace(0.9, 1.1, PACKS).astype(precision)
    F_E, kept, tau, _, modulus = response(core, F, J_P, law, precision)
    np.testing.assert_array_equal(F_E, F.astype(float))
    np.testing.assert_array_equal(kept, J_P.astype(float))
    h = law.hardening(J_P.astype(float))
    expected = oracle.kirchhoff(F.astype(float), J_P.astype(float), law)
    np.testing.assert_allclose(
        tau / h[:, None, None], expected / h[:, None, None], rtol=0, atol=30 * eps * law.M_c
    )
    s = np.linalg.svd(F.astype(float), compute_uv=False)
    J = s.prod(axis=1)
    if law.law == "stomakhin2013":
        answer = 2 * law.mu0 * s[:, 0] ** 2 + law.lam0 * J**2
    else:
        answer = law.mu0 * s[:, 0] ** 2 + law.mu0 + law.lam0 * (1 - np.log(J))
    spread = eps ** (1 / 3) * np.abs(s - 1).max() + 30 * eps
    np.testing.assert_allclose(modulus / (answer * h), 1, rtol=0, atol=spread)


@pytest.mark.parametrize("law", [law for law in SNOWS if law.plasticity != "none"], ids=lambda law: law.law)
def test_one_that_flows_changes_no_other(law):
    """Beside a particle that flows a pack takes the way of the stretches, and nobody else flows."""
    F = stretched(law, 0.9, seed=8)
    alone = response(_f64(), F, 1.0, law)
    F_flows = F.copy()
    F_flows[3::16] = np.diag([1 + 2 * law.theta_s, 1.0, 1.0])
    beside = response(_f64(), F_flows, 1.0, law)
    others = np.arange(PACKS) % 16 != 3
    np.testing.assert_array_equal(beside[1] != 1, ~others)
    np.testing.assert_array_equal(beside[0][others], F[others])
    np.testing.assert_allclose(beside[2][others], alone[2][others], rtol=0, atol=1e-13 * law.M_c)
    np.testing.assert_allclose(beside[4][others], alone[4][others], rtol=1e-5)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("side", ["theta_c", "theta_s"])
def test_the_thresholds_are_where_they_were(side, turned):
    """A stretch of one axis 1e-9 short of its threshold does not flow, one 1e-9 beyond does."""
    law = LAWS["stomakhin2013"]
    limit = 1 - law.theta_c if side == "theta_c" else 1 + law.theta_s
    for by, flows in ((-1e-9, False), (1e-9, True)):
        stretch = limit + (by if side == "theta_s" else -by)
        F = np.broadcast_to(np.diag([stretch, 1.0, 1.0]), (16, 3, 3))
        F = turns(16, 1) @ F @ turns(16, 2) if turned else F.copy()
        assert (response(_f64(), F, 1.0, law)[1] != 1).all() == flows


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("side", ["theta_c", "theta_s"])
def test_what_is_beyond_on_all_axes_flows(core, precision, side):
    """Near a point where all stretches meet at their threshold, one beyond it by 20 eps or more flows."""
    law, rng = LAWS["stomakhin2013"], np.random.default_rng(4)
    limit, out = (1 - law.theta_c, -1) if side == "theta_c" else (1 + law.theta_s, 1)
    beyond = 10 ** rng.uniform(-5 if precision == "float32" else -13, -3, PACKS)
    within = beyond[:, None] * rng.uniform(0.5, 4, (PACKS, 2))
    stretches = limit + out * np.column_stack([beyond, -within])
    U, V = turns(PACKS, 1), turns(PACKS, 2)
    F = ((U * stretches[:, None, :]) @ transpose(V)).astype(precision)
    J_P = response(core, F, 1.0, law, precision)[1]
    assert (J_P != 1).all()


def test_a_mirror_is_not_small():
    """F F^T of a reflection is the identity's, but its snow is inside out and takes the way of the SVD."""
    law = LAWS["stomakhin2013"]
    F = np.broadcast_to(np.diag([1.0, 1.0, -1.0]), (16, 3, 3)).copy()
    F_E, J_P, *_ = response(_f64(), F, 1.0, law)
    assert (np.linalg.det(F_E) > 0).all() or (J_P < 0).all()


def _f64():
    from neve import _core

    return _core.f64
