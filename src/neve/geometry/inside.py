"""Ask where a mesh is filled, whatever its triangles overlap or which way they look."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.geometry.triangles import Triangles

Array = NDArray[np.float64]

POINTS = 24
"""Points along each edge of the box, at which overlaps of a surface with itself are looked for."""
LINES = 48
"""Lines along each edge of the box on which parts that overlap are measured."""
MOST_MET = 10_000
"""Faces that a line may meet."""


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


def volume(surface: Triangles) -> float:
    """Return the volume inside [m3], each point once however many parts overlap there; holes are closed.

    The divergence theorem counts space as often as the surface winds round it; see `times_around`.
    """
    times = times_around(surface)
    return surface.closed_volume / times if times > 0 else 0.0


def times_around(surface: Triangles) -> float:
    """Return how often the surface winds round its inside, on average: 1 unless parts overlap.

    Along LINES^2 lines through the box of each axis, one at random in each square, from face to face: lengths
    times winding numbers over lengths inside. Exact along the lines, and across them no worse than
    their distance times the share of space that overlaps. 0 if there is no inside.
    """
    _, winding = windings(surface, surface.low, surface.high, POINTS)
    if (winding == 1).all() and not _boxes_overlap(surface):
        return 1.0
    rng = np.random.default_rng(0)
    lengths, often = np.concatenate([_along(surface, axis, rng) for axis in range(3)], axis=1)
    inside = often != 0
    if (often[inside] == 1).all():
        return 1.0
    return float((lengths * often).sum() / lengths[inside].sum())


def _boxes_overlap(surface: Triangles) -> bool:
    """Return whether the boxes around any two parts of a surface have more in common than a side."""
    order = np.argsort(surface.parts, kind="stable")
    begin = np.flatnonzero(np.diff(surface.parts[order], prepend=-1))
    if len(begin) == 1:
        return False
    corners = surface.vertices[surface.faces[order]]
    low = np.minimum.reduceat(corners.min(axis=1), begin)
    high = np.maximum.reduceat(corners.max(axis=1), begin)
    room = 1e-6 * float((surface.high - surface.low).max())
    for k in range(len(begin) - 1):
        if ((low[k + 1 :] < high[k] - room) & (high[k + 1 :] > low[k] + room)).all(axis=1).any():
            return True
    return False


def _along(surface: Triangles, axis: int, rng: np.random.Generator) -> Array:
    """Return lengths [m] and winding numbers of all pieces of lines along `axis` between faces, (2, n)."""
    low, high = surface.low, surface.high
    size = high - low
    square = np.stack(np.meshgrid(np.arange(LINES), np.arange(LINES), indexing="ij"), axis=-1).reshape(-1, 2)
    start = np.empty((LINES**2, 3))
    start[:, [k for k in range(3) if k != axis]] = (square + rng.random(square.shape)) / LINES
    start = low + start * size
    step = 1e-9 * float(size.max())
    start[:, axis] = low[axis] - step
    ahead = np.zeros_like(start)
    ahead[:, axis] = 1.0
    middles, lengths = [], []
    for n in range(MOST_MET):
        t, face = surface.tree.ray(np.ascontiguousarray(start), np.ascontiguousarray(ahead[: len(start)]))
        met = face >= 0
        start, t = start[met], t[met]
        if not len(start):
            break
        if n > 0:
            middle = start.copy()
            middle[:, axis] += 0.5 * t
            middles.append(middle[t > step])
            lengths.append(t[t > step])
        start[:, axis] += t + step
    if not middles:
        return np.zeros((2, 0))
    return np.stack([np.concatenate(lengths), np.rint(surface.tree.winding(np.concatenate(middles)))])
