"""Polygons seen from above: which points they hold, their area, and whether their sides cross."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHUNK = 2**22
"""Pairs of points and sides that are looked at together."""


def area_of(corners: Array) -> float:
    """Return the area [m2] of the polygon `corners` [m] (n, 2), in either order (Gauss's formula)."""
    x, y = (corners - corners[0]).T
    return float(abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2)


def holds(corners: Array, points: Array) -> NDArray[np.bool_]:
    """Return which points [m] (k, 2) lie in the polygon `corners` [m] (n, 2), by the even-odd rule, (k,)."""
    a, b = corners, np.roll(corners, -1, axis=0)
    inside = np.zeros(len(points), dtype=bool)
    step = max(1, CHUNK // len(corners))
    for begin in range(0, len(points), step):
        x, y = (points[begin : begin + step, k, None] for k in (0, 1))
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
        meets = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
        inside[begin : begin + step] = np.count_nonzero(spans & (x < meets), axis=1) % 2 == 1
    return inside


def crossing(corners: Array) -> tuple[int, int] | None:
    """Return two sides of the polygon `corners` (n, 2) that cross, by their first corners, if any do."""
    a, b = corners, np.roll(corners, -1, axis=0)

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.asarray((q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1])) - np.asarray(
            (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])
        )

    for i in range(len(corners)):
        apart = side(a[i], b[i], a) * side(a[i], b[i], b) < 0
        found = np.flatnonzero(apart & (side(a, b, a[i]) * side(a, b, b[i]) < 0))
        if len(found):
            return i, int(found[0])
    return None
