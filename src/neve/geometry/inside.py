"""Ask where a mesh is filled, whatever its triangles overlap or which way they look."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.geometry.triangles import Triangles

Array = NDArray[np.float64]


def windings(surface: Triangles, low: Array, high: Array, count: int) -> tuple[Array, Array]:
    """Return which of count^3 cells of the box from `low` to `high` [m] (3,) are inside, and how often.

    Their middles [m] (n, 3), and how often the surface winds round each (n,), a whole number other than 0:
    1 everywhere if the surface neither overlaps itself nor is inside out anywhere.
    """
    shares = (np.arange(count) + 0.5) / count
    points = np.stack(np.meshgrid(shares, shares, shares, indexing="ij"), axis=-1).reshape(-1, 3)
    points = low + points * (high - low)
    winding = np.rint(surface.tree.winding(points))
    inside = winding != 0
    return points[inside], winding[inside]
