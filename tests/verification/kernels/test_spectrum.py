"""B = F F^T - I: its eigenvalues, and isotropic functions of it, against LAPACK in float64."""

import numpy as np
import pytest
from verification.material import transpose, turns

STRETCHES = {
    "apart": (1.02, 0.99, 0.95),
    "one axis": (0.96, 1.0, 1.0),
    "two axes": (1.01, 1.01, 0.97),
    "nearly two": (1.01, 1.01 + 1e-6, 0.97),
    "nearly two below": (1.01, 0.97, 0.97 - 1e-5),
    "all": (0.97, 0.97, 0.97),
    "nearly all": (0.97, 0.97 + 1e-6, 0.97 - 1e-6),
    "rotation": (1.0, 1.0, 1.0),
    "large": (2.5, 1.1, 0.6),
    "large, two axes": (0.6, 2.5, 2.5),
}


def stretched(stretches, n=1000):
    """Return F = Q diag(stretches) R^T (n, 3, 3) of random rotations."""
    return (turns(n, 3) * np.array(stretches)) @ transpose(turns(n, 4))


def exact(F):
    """Return the eigenvalues (n, 3), rising, and eigenvectors of F F^T - I."""
    F = F.astype(float)
    return np.linalg.eigh(F @ transpose(F) - np.eye(3))


def function(y, e, V):
    return (V * y(e)[:, None, :]) @ transpose(V)


@pytest.mark.parametrize("kind", STRETCHES)
def test_eigenvalues(core, precision, eps, kind):
    """Weyl: each is off by no more than the rounding of F F^T, three products each of (1 + e), and of D."""
    F = stretched(STRETCHES[kind]).astype(precision)
    e = np.sort(core.isotropic_function(F, np.zeros((len(F), 3), precision))[0], axis=1)
    answer = exact(F)[0]
    np.testing.assert_allclose(e, answer, rtol=0, atol=6 * eps * (1 + np.abs(answer).max()))


@pytest.mark.parametrize("kind", STRETCHES)
def test_functions(core, precision, eps, kind):
    """A smooth function, and one with a kink in the midst of the eigenvalues, as a yield strain is."""
    F = stretched(STRETCHES[kind]).astype(precision)
    e, V = exact(F)
    kink = np.median(e)
    size = 1 + np.abs(e).max()
    for y in (lambda e: 1 - 1 / np.sqrt(1 + e), lambda e: np.clip(e, None, kink)):
        given = core.isotropic_function(F, np.zeros((len(F), 3), precision))[0].astype(float)
        Y = core.isotropic_function(F, y(given).astype(precision))[1]
        np.testing.assert_allclose(Y, function(y, e, V), rtol=0, atol=30 * eps * size)


def test_the_one_apart_comes_first(core, precision):
    """It lies at least as far from the middle one as that from the third."""
    F = (np.eye(3) + 0.02 * np.random.default_rng(0).standard_normal((1000, 3, 3))).astype(precision)
    e = core.isotropic_function(F, np.zeros((len(F), 3), precision))[0]
    assert (e[:, 1] >= e[:, 2]).all()
    apart = np.minimum(np.abs(e[:, 0] - e[:, 1]), np.abs(e[:, 0] - e[:, 2]))
    assert (apart >= (e[:, 1] - e[:, 2]) * (1 - 1e-3)).all()


def test_what_is_not_a_number_stays_one(core, precision):
    F = np.tile(np.eye(3, dtype=precision), (16, 1, 1))
    F[3, 0, 1] = np.nan
    e, Y = core.isotropic_function(F, np.ones((16, 3), precision))
    assert np.isnan(e[3]).all()
    assert np.isnan(Y[3]).any()
    assert (np.delete(e, 3, axis=0) == 0).all()
