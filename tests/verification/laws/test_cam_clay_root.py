"""cam_clay's return map against roots found in another way, for constants drawn from all of their ranges."""

import numpy as np
import pytest
from reference.snow import Snow
from scipy.optimize import brentq
from verification.material import respond

SNOWS, STATES, MOST_XI = 60, 10, 100.0


def drawn(rng):
    """Constants over the whole of their ranges, and states: strains of 1e-4 to 0.5, J_P of 0.5 to 2."""
    E0, nu = float(np.exp(rng.uniform(*np.log([1e4, 1e8])))), float(rng.uniform(0, 0.45))
    law = Snow(
        law="cam_clay",
        E0=E0,
        nu=nu,
        xi=float(np.exp(rng.uniform(*np.log([0.5, MOST_XI])))),
        M=float(rng.uniform(0.1, 3)),
        beta=float(rng.choice([0.0, 1.0, rng.uniform()])),
        p0=float(np.exp(rng.uniform(*np.log([1e-5, 0.1])))) * E0 / (3 * (1 - 2 * nu)),
    )
    size = np.exp(rng.uniform(*np.log([1e-4, 0.5]), STATES))
    return law, size[:, None] * rng.standard_normal((STATES, 3)), np.exp(rng.uniform(-0.7, 0.7, STATES))


def flow(p_trial, q_trial, p0, law):
    """The points (p, q) of ellipses of p0 [Pa] (n,) whose normal leads to the trial stress [Pa].

    On an ellipse p = c + a cos s, q = b sin s, s in [0, pi]. The plastic strain (p_trial - p) / K,
    (q_trial - q) / (3 mu) is along (dy/dp, dy/dq), that is along (b cos s, a sin s): one root in s, bisected.
    """
    c, a = 0.5 * (1 - law.beta) * p0, 0.5 * (1 + law.beta) * p0
    b = law.M * a / np.sqrt(1 + 2 * law.beta)
    low, high = np.zeros_like(p0), np.full_like(p0, np.pi)
    for _ in range(55):
        s = 0.5 * (low + high)
        along, across = (p_trial - c - a * np.cos(s)) / law.K, (q_trial - b * np.sin(s)) / (3 * law.mu0)
        before = along * a * np.sin(s) < across * b * np.cos(s)
        low, high = np.where(before, s, low), np.where(before, high, s)
    return c + a * np.cos(s), b * np.sin(s)


def end(law, eps, J_P):
    """p and q [Pa] at the end of a step from the logarithmic strains eps (3,); None where nothing flows.

    p0 = K sinh(w), w = asinh(p0_ini / K) - xi ln J_P at the end, between 1e-6 K, 10 K and the bounds of J_P.
    Of several roots it is the first one from the w of the start, on the side to which that is driven.
    """
    volume = eps.sum()
    p, q = -law.K * volume, np.sqrt(6) * law.mu0 * np.linalg.norm(eps - volume / 3)
    rest = np.arcsinh(law.p0 / law.K)
    bounds = np.clip(rest - law.xi * np.log([law.J_P_max, law.J_P_min]), 1e-6, np.arcsinh(10))
    free = rest - law.xi * np.log(J_P)
    start = np.clip(free, *bounds)

    def driven(w):
        w = np.atleast_1d(w)
        kept = -flow(p, q, law.K * np.sinh(w), law)[0] / law.K
        return np.clip(free + law.xi * (kept - volume), *bounds) - w

    p0 = law.K * np.sinh(start)
    if (1 + 2 * law.beta) * q**2 + law.M**2 * (p + law.beta * p0) * (p - p0) <= 0:
        return None
    w = start
    if (first := driven(start)[0]) != 0:
        far = bounds[1] if first > 0 else bounds[0]
        path = start + (far - start) * np.linspace(0, 1, 400) ** 2
        path[-1] = far
        turns = np.flatnonzero(np.sign(driven(path[1:])) != np.sign(first))
        near = path[turns[0]]
        w = brentq(lambda w: driven(w)[0], near, path[turns[0] + 1], xtol=1e-15, rtol=1e-15)
    return tuple(float(part[0]) for part in flow(p, q, law.K * np.sinh(np.atleast_1d(w)), law))


def test_end_is_the_first_root(core, precision, eps):
    """p and q are those of the oracle, for xi from 0.5 to 100, any M, beta and p0, in one step of any size.

    Strains p / K and q / K carry roundings of the strains, of p0 / K <= 10 and of the exponent's w <= 3: some
    200 eps in all; where a root is flat, as much as the oracle's answer moves with strains changed by 20 eps.
    """
    rng = np.random.default_rng(57)
    flowed = 0
    for _ in range(SNOWS):
        law, strains, J_P = drawn(rng)
        F = (np.exp(strains)[:, :, None] * np.eye(3)).astype(precision)
        J_P = J_P.astype(precision).astype(float)
        tau = respond(core, F, J_P, law, precision)[2]
        strains = np.log(np.diagonal(F, axis1=1, axis2=2).astype(float))
        p = -np.trace(tau, axis1=1, axis2=2) / 3
        q = np.sqrt(1.5) * np.linalg.norm(tau + p[:, None, None] * np.eye(3), axis=(1, 2))
        for i in range(STATES):
            if (answer := end(law, strains[i], J_P[i])) is None:
                continue
            flowed += 1
            slack = 200 * eps
            moved = end(law, strains[i] * (1 + 20 * eps), J_P[i]) or answer
            slack += 4 * np.abs(np.subtract(moved, answer)).max() / law.K
            found = np.array([p[i] - answer[0], q[i] - answer[1]]) / law.K
            np.testing.assert_allclose(found, 0, atol=slack, err_msg=f"{law}, {strains[i]}, {J_P[i]}")
    assert flowed > 0.4 * SNOWS * STATES


@pytest.mark.parametrize("beta", [0.0, 0.3])
def test_hard_snow_does_not_pull(core, precision, eps, beta):
    """Snow of xi = 57 pressed to half, then pulled, bears beta p0 <= beta 10 K: without beta nothing.

    p0 stops at 10 K, so that what rounding leaves of it is 10 eps K; unbounded it would be 1e12 K.
    """
    law = Snow(law="cam_clay", E0=3e6, nu=0.3, xi=57.0, M=1.0, beta=beta, p0=3e3)
    tau = respond(core, 1.05 * np.eye(3)[None], 0.5, law, precision)[2]
    pull = np.trace(tau[0]) / 3
    assert pull <= min(beta * 10, 3 * np.log(1.05)) * law.K + 100 * eps * law.K
    assert (pull > 0.1 * law.K) == (beta > 0)
