"""Products by the rigid-body engine, whose code gives the same bits on every processor.

For matrices of as many columns as there are degrees of freedom; of three, `neve.reproducible` is quicker.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.rigid.engine import engine

Array = NDArray[np.float64]


def times(matrix: Array, vector: NDArray[Any]) -> Array:
    """Return the product (n,) of `matrix` (n, k) and `vector` (k,)."""
    found = np.zeros(len(matrix))
    if matrix.size:
        engine().mju_mulMatVec(found, matrix, vector)
    return found
