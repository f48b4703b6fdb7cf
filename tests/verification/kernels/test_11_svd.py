"""Known answer 11: the decomposition F = U diag(sigma) V^T with rotations, whatever F is."""

import numpy as np
import pytest
from reference.snow import polar_svd
from verification.material import near_identity, transpose, turns


def matrices(kind, n=2000):
    rng = np.random.default_rng(11)
    Q, R = turns(n, 12), turns(n, 13)

    def of(s):
        return (Q * np.broadcast_to(s, (n, 3))[:, None, :]) @ transpose(R)

    if kind == "random":
        return rng.standard_normal((n, 3, 3))
    if kind == "huge":
        return 1e6 * rng.standard_normal((n, 3, 3))
    if kind == "near identity":
        return near_identity(n, 1e-3)
    if kind == "identity":
        return np.tile(np.eye(3), (n, 1, 1))
    if kind == "inverted":
        return of([1.2, 0.9, -0.3])
    if kind == "rotation":
        return Q
    if kind == "two equal":
        return of([1.1, 1.1, 0.7])
    if kind == "flat":
        return of([1.0, 0.5, 0.0])
    if kind == "line":
        return of([1.0, 0.0, 0.0])
    if kind == "zero":
        return np.zeros((n, 3, 3))
    return of(10.0 ** rng.uniform(-4, 4, (n, 3)))  # "wide": stretches over eight decades


KINDS = [
    "random",
    "huge",
    "near identity",
    "identity",
    "inverted",
    "rotation",
    "two equal",
    "flat",
    "line",
    "zero",
]


@pytest.mark.parametrize("kind", KINDS)
def test_svd(core, precision, eps, kind):
    """U diag(sigma) V^T = F, U and V rotations, sigma ordered with the sign in the last.

    A backward stable decomposition reproduces F to a small multiple of eps |F|; rotations of three Jacobi
    angles a sweep, each rounded to a few eps, stay orthogonal to 5 sweeps x 3 x 2 eps = 30 eps.
    """
    F = matrices(kind).astype(precision)
    U, sigma, V = (np.asarray(a, float) for a in core.svd(F))
    size = np.linalg.norm(F.astype(float), axis=(1, 2))[:, None, None] + 1e-300
    np.testing.assert_allclose(((U * sigma[:, None, :]) @ transpose(V) - F) / size, 0, atol=30 * eps)
    for rotation in (U, V):
        np.testing.assert_allclose(transpose(rotation) @ rotation - np.eye(3), 0, atol=30 * eps)
        np.testing.assert_allclose(np.linalg.det(rotation), 1, atol=60 * eps)
    slack = 30 * eps * size[:, 0, 0]
    assert (sigma[:, 0] >= sigma[:, 1] - slack).all()
    assert (sigma[:, 1] >= np.abs(sigma[:, 2]) - slack).all()


def test_wide_range(core, precision, eps):
    """Stretches over eight decades: what a method that goes through F^T F - I can keep, and no less.

    It leaves columns b_k = F v_k whose products are rounding of F^T F - I: |b_i . b_j| <= 4 eps (1 +
    sigma_1^2). Each b_k is then split along rotated axes, and what is dropped is such a product over |b_i|:
    4 eps (1 + sigma_1^2) / sigma_2, never more than |b_2| itself, whose square is at most sigma_2^2 + 4 eps
    (1 + sigma_1^2).
    """
    F = matrices("wide").astype(precision)
    U, sigma, V = (np.asarray(a, float) for a in core.svd(F))
    exact = polar_svd(F.astype(float))[1]
    noise = 4 * eps * (1 + exact[:, 0] ** 2)
    dropped = np.minimum(noise / exact[:, 1], np.sqrt(exact[:, 1] ** 2 + noise))
    error = np.linalg.norm((U * sigma[:, None, :]) @ transpose(V) - F, axis=(1, 2))
    assert (error <= 2 * dropped + 30 * eps * exact[:, 0]).all()
    for rotation in (U, V):
        np.testing.assert_allclose(transpose(rotation) @ rotation - np.eye(3), 0, atol=30 * eps)


@pytest.mark.parametrize("kind", ["random", "near identity", "inverted", "two equal", "flat"])
def test_singular_values(core, precision, eps, kind):
    """sigma equals LAPACK's in float64.

    Weyl: a backward error of 30 eps |F| moves sigma by no more, if the method is backward stable. Going
    through F^T F costs the small values more, error eps sigma_1^2 / sigma_3, which a method may not pay
    where snow lives (stretches near one) nor where sigma_3 is zero (error sqrt(eps) there); hence one bound
    for all.
    """
    F = matrices(kind).astype(precision)
    sigma = np.asarray(core.svd(F)[1], float)
    exact = polar_svd(F.astype(float))[1]
    no_sign = np.abs(exact[:, 2]) < 30 * eps * exact[:, 0]
    sigma[no_sign, 2], exact[no_sign, 2] = np.abs(sigma[no_sign, 2]), np.abs(exact[no_sign, 2])
    np.testing.assert_allclose(sigma / exact[:, :1], exact / exact[:, :1], atol=30 * eps)
