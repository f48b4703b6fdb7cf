"""Determinants outside the core: one formula for one matrix and for many."""

import numpy as np

from neve.reproducible import determinant


def test_determinants(precision, eps):
    """det of products of known ones; within rounding, the same bits one by one, nan without a word."""
    rng = np.random.default_rng(0)
    L = np.tril(rng.uniform(-1, 1, (200, 3, 3)), -1) + np.eye(3)
    U = np.triu(rng.uniform(0.5, 2, (200, 3, 3)))
    exact = U[:, 0, 0] * U[:, 1, 1] * U[:, 2, 2]  # det(L U) = det U
    A = (L @ U).astype(precision)
    found = determinant(A)
    assert found.dtype == A.dtype
    assert np.abs(found - exact).max() < 200 * eps  # six products of numbers below 2 + 2 + 2, rounded input
    assert np.array_equal(found, [determinant(one) for one in A])
    assert np.isnan(determinant(np.full((3, 3), np.inf)))
