"""Products and functions that give the same bits on every processor.

NumPy hands `@`, `np.dot`, the norm of one vector and `np.linalg` to a BLAS library, and e^x, powers and arcs
to vector code, and both choose by the processor how they add and round. What the particles start from, and
what moves colliders and bodies, goes through this module instead: elementwise products and sums in one
order, each rounded by IEEE 754. `np.sum` adds in an order that follows from the shape alone; `math` does the
same on all processors that fuse multiplication and addition.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""ln 2 in two parts: a whole number below 2^20 times the first is exact."""
DEGREE = 13
"""Of the polynomial of `exp`: the next term is below 5e-18."""
SWEEPS = 12
"""Most rounds of `eigen`; five bring any matrix to rounding."""


def product(a: NDArray[Any], b: NDArray[Any]) -> Array:
    """Return the matrix product a b as np.matmul does, each sum from its first term to its last.

    a (..., n, k) or (k,), b (..., k, m) or (k,); meant for a small k, since it is a loop over k.
    """
    if b.ndim == 1:
        return np.asarray(product(a, b[:, None])[..., 0])
    if a.ndim == 1:
        return np.asarray(product(a[None], b)[..., 0, :])
    if a.shape == b.shape == (3, 3) and a.dtype == b.dtype == np.float64:
        return _product_of_few(a, b)
    total = a[..., :, :1] * b[..., :1, :]
    for k in range(1, a.shape[-1]):
        total += a[..., :, k : k + 1] * b[..., k : k + 1, :]
    return np.asarray(total)


def _product_of_few(a: NDArray[np.float64], b: NDArray[np.float64]) -> Array:
    """Return `product` of two matrices (3, 3), for which NumPy takes four times as long."""
    (b0, b1, b2), (b3, b4, b5), (b6, b7, b8) = b.tolist()
    return np.array(
        [
            (x * b0 + y * b3 + z * b6, x * b1 + y * b4 + z * b7, x * b2 + y * b5 + z * b8)
            for x, y, z in a.tolist()
        ]
    )


def norms(vectors: NDArray[Any]) -> Array:
    """Return the length of each vector (..., k) along the last axis."""
    return np.asarray(np.sqrt(np.sum(vectors * vectors, axis=-1)))


def determinant(matrices: NDArray[Any]) -> NDArray[Any]:
    """Return the determinant of each matrix (..., 3, 3), in the precision of the matrices."""
    a, b, c = np.moveaxis(matrices, (-2, -1), (0, 1))
    with np.errstate(over="ignore", invalid="ignore"):  # who asks looks whether it is finite
        x, y, z = b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]
        return np.asarray(a[0] * x + a[1] * y + a[2] * z)


def exp(x: NDArray[Any]) -> Array:
    """Return e^x, elementwise, within 2 units in the last place.

    x = n ln 2 + r with |r| <= ln 2 / 2, and e^x = 2^n e^r with the power series of e^r.
    """
    n = np.rint(x * (1.0 / math.log(2.0)))
    r = (x - n * LN2_HIGH) - n * LN2_LOW
    series = np.full_like(r, 1.0 / math.factorial(DEGREE))
    for k in range(DEGREE - 1, -1, -1):
        series = series * r + 1.0 / math.factorial(k)
    return np.asarray(np.ldexp(series, np.clip(n, -2000, 2000).astype(np.int32)))


def eigen(matrix: NDArray[Any]) -> tuple[Array, Array]:
    """Return the eigenvalues (3,) of a symmetric `matrix` (3, 3), the least first, and its eigenvectors.

    They are the columns of a right-handed matrix (3, 3). Cyclic Jacobi rotations, the angle by Golub and
    Van Loan 2013, section 8.5 [M].
    """
    a = np.array(matrix, dtype=np.float64)
    vectors = np.eye(3)
    for _ in range(SWEEPS):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if a[p, q] == 0.0:
                continue
            tau = float(a[q, q] - a[p, p]) / (2.0 * float(a[p, q]))
            t = math.copysign(1.0, tau) / (abs(tau) + math.sqrt(1.0 + tau * tau))
            c = 1.0 / math.sqrt(1.0 + t * t)
            turn = np.eye(3)
            turn[[p, q], [p, q]], turn[p, q], turn[q, p] = c, t * c, -t * c
            a = product(product(turn.T, a), turn)
            a[p, q] = a[q, p] = 0.0
            vectors = product(vectors, turn)
    order = np.argsort(np.diag(a), kind="stable")
    vectors = vectors[:, order]
    if determinant(vectors) < 0:
        vectors[:, 2] = -vectors[:, 2]
    return np.diag(a)[order], vectors
