"""Learned energies of cam-clay: what hardens in a step, snow that has softened, and steps with them."""

import numpy as np
import pytest
from verification.scenes import ball, columns, scene, simulate

from neve import _core
from neve.learned.clay import LAW, ellipse, stress, told, with_deviator
from neve.learned.network import Network
from neve.learned.network import stress as network_stress
from neve.learned.samples import context
from neve.learned.shipped import weights_of

SNOW = {"xi": 1.0, "M": 0.5, "beta": 0.0, "nu": 0.3}  # as the scene has it if it names no constants
GROUND = [{"shape": "plane", "mu_c": 0.3, "point": [0, 0, 0], "normal": [0, 0, 1]}]


def network():
    """Return the network that comes with Neve as the trainer has it."""
    given = {name: np.array(row) for name, row in weights_of(LAW).items()}
    hidden = given["w"].size
    for name in ("W", "V"):
        given[name] = given[name].reshape(hidden, -1)
    return Network(**given)


def test_units_are_those_of_the_core():
    """The core and the trainer tell the network the same: how P changes from F0 to F, to 1e-10 of it.

    C is the same at both, and r is 0.
    """
    rng = np.random.default_rng(2)
    bulk, _, aspect = ellipse(SNOW)
    E0, J_P = 1e5, 0.99
    s = np.sinh(np.arcsinh(2e-3) - SNOW["xi"] * np.log(J_P))
    e0, e = 0.01 * rng.normal(size=(2, 50, 3))
    given = SNOW | {"E0": E0, "p0": 2e-3 * bulk * E0}
    F0, F = (np.exp(a)[:, None, :] * np.eye(3) for a in (e0, e))
    at = [
        _core.f64.learned_response(
            LAW, given, weights_of(LAW), F0, np.full(50, J_P), X, np.zeros_like(X), regularity=0.0
        )[0]
        for X in (F, F0)
    ]
    found = np.einsum("nii->ni", at[0] - at[1])
    u0, u = (with_deviator(a, 1 / aspect) for a in (e0, e))
    unit = np.sqrt(s**2 + (u0**2).sum(1, keepdims=True))
    y = context(0 * u0, told(s / unit, SNOW))
    P = [
        with_deviator(network_stress(network(), a / unit, y) * unit, 1 / aspect) * bulk * E0 / np.exp(b)
        for a, b in ((u, e), (u0, e0))
    ]
    np.testing.assert_allclose(found, P[0] - P[1], atol=1e-10 * np.abs(found).max(), rtol=0)


@pytest.mark.parametrize("xi", [0.2, 1.0])
def test_the_law_hardens_in_a_step(xi):
    """Pressed evenly by v, snow of small p0 = K s bears p / K = (s + xi v) / (1 + xi): its p0 is p, that of
    s + xi (v - p).

    To the curvature of sinh, v^2: the samples have hardening in them.
    """
    s, v = 1e-4, np.array([[2e-4], [1e-3], [5e-3]])
    found = stress(SNOW | {"xi": xi}, -v / 3 * np.ones(3), np.full(3, np.arcsinh(s)))
    p = (s + xi * v) / (1 + xi)
    np.testing.assert_allclose(-found.mean(1, keepdims=True), p, rtol=2e-4)


@pytest.mark.parametrize("xi", [0.2, 1.0])
def test_the_network_knows_that_it_hardens(xi):
    """The slope xi / (1 + xi) of that pressure, where an energy at fixed hardening has none: to a tenth of K.

    Of snow that has softened to a hundredth of the strain that it is pressed by.
    """
    share = np.array([[0.01]])
    y = context(np.zeros((1, 3)), told(share, SNOW | {"xi": xi}))
    up, down = (network_stress(network(), np.full((1, 3), -v / 3), y).mean() for v in (1.3, 0.7))
    assert (down - up) / 0.6 == pytest.approx(xi / (1 + xi), abs=0.1)


def fallen(dt, plasticity, seconds=0.05, **how):
    """Drop a ball of loose snow on the ground; its width [m], mean height [m], and the simulation."""
    source = [ball(center=(0, 0, 0.15), velocity=(0, 0, -2))]
    how = {"integrator": "implicit", "dt": dt, "precision": "float64"} | how
    if how["integrator"] == "implicit":
        how |= {"implicit_plasticity": plasticity, "implicit_strain": 1.0}
    sim = simulate(scene(source, GROUND, (0.0, 0.0, -9.81), snow={"law": LAW}, **how))
    sim.advance(seconds)
    x = columns(sim)["x"]
    return np.array([x[:, 0].std(), x[:, 2].mean()]), sim


def test_the_same_steps_as_with_the_return_map():
    """A ball that crumbles, in steps of a millisecond: to the tolerance of a solve, 1 %; none is refused."""
    learned, sim = fallen(1e-3, "learned")
    assert sim.stats.rejected == 0
    np.testing.assert_allclose(learned, fallen(1e-3, "return_map")[0], rtol=0.01)


def test_short_steps_end_where_explicit_ones_do():
    """Steps of 0.1 ms, of both kinds, within 2 %."""
    learned, _ = fallen(1e-4, "learned", seconds=0.02)
    explicit, _ = fallen(1e-4, None, seconds=0.02, integrator="explicit")
    np.testing.assert_allclose(learned, explicit, rtol=0.02)
