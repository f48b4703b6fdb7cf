"""Products and solutions by the rigid-body engine, whose code gives the same bits on every processor.

For matrices of as many columns as there are degrees of freedom; of three, `neve.reproducible` is quicker.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.rigid.engine import engine

Array = NDArray[np.float64]

LEAST_PIVOT = 1e-15
"""Least pivot of `solved`, as in the engine: what has no inertia yields no further than that allows."""


def times(matrix: Array, vector: NDArray[Any]) -> Array:
    """Return the product (n,) of `matrix` (n, k) and `vector` (k,)."""
    found = np.zeros(len(matrix))
    if matrix.size:
        engine().mju_mulMatVec(found, matrix, vector)
    return found


def times_transposed(a: Array, b: Array) -> Array:
    """Return a b^T (n, m) of matrices `a` (n, k) and `b` (m, k)."""
    found = np.zeros((len(a), len(b)))
    if a.size and b.size:
        engine().mju_mulMatMatT(found, a, b)
    return found


def solved(matrix: Array, rows: Array) -> Array:
    """Return X (m, k), each row of which solves `matrix` x = row; `rows` (m, k).

    `matrix` (k, k): symmetric and positive definite; by Cholesky's decomposition.
    """
    factor = np.array(matrix, dtype=np.float64)
    found = np.zeros_like(rows)
    if rows.size:
        engine().mju_cholFactor(factor, LEAST_PIVOT)
        for x, row in zip(found, rows, strict=True):
            engine().mju_cholSolve(x, factor, row)
    return found
