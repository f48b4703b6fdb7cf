"""Height maps as triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def thinned(heights: NDArray[Any], size: tuple[float, float], most: int) -> tuple[Array, Array, Array]:
    """Return places x (n,) and y (m,) [m] and heights (n, m) [m] of a map, at most `most` along each side.

    A map with more samples is thinned as evenly as whole rows allow, each kept one at its own place, the
    outermost among them. heights (nx, ny) [m]; size: of the map [m], its middle at 0.
    """
    rows = [np.unique(np.linspace(0, n - 1, min(n, most)).astype(int)) for n in heights.shape]
    x, y = ((r / (n - 1) - 0.5) * length for r, n, length in zip(rows, heights.shape, size, strict=True))
    return x, y, heights[np.ix_(*rows)].astype(np.float64)


def triangulated(x: Array, y: Array, heights: Array) -> tuple[Array, NDArray[np.int32]]:
    """Return corners (n m, 3) [m] and triangles (k, 3), anticlockwise from above, of heights (n, m) [m]."""
    corners = np.stack([*np.meshgrid(x, y, indexing="ij"), heights], axis=-1).reshape(-1, 3)
    i = np.arange(heights.size, dtype=np.int32).reshape(heights.shape)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    return corners, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
