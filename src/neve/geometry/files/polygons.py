"""Cut polygons into triangles: concave ones, with corners in line, not quite flat.

A polygon in space is seen along its area vector, the sum of c_i x c_(i+1) / 2 over its corners (Newell's
normal), in the plane of the two axes that foreshorten it least, so that corners in line stay so to the bit.
There ears are cut off (Meisters 1975, Polygons have ears): corners whose neighbours see each other inside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.geometry.files.wording import Faces
from neve.reproducible import norms

Array = NDArray[np.float64]

FLAT = 1e-7
"""Twice the area of a corner, in squares of the polygon's extent, below which its two edges are in line."""


def triangulated(vertices: Array, corners: Faces, counts: Faces) -> Faces:
    """Return triangles (m, 3) that fill polygons, in the order of the polygons.

    vertices: (n, 3); corners: rows of `vertices`, polygon by polygon, (sum of counts,); counts: corners of
    each polygon (p,). What has fewer than three corners is left out. A polygon of n corners gives n - 2
    triangles, so that a corner in line with its neighbours stays a corner of two of them.
    """
    begin = np.cumsum(counts) - counts
    pieces = np.maximum(counts - 2, 0)
    place = np.cumsum(pieces) - pieces
    out = np.zeros((int(pieces.sum()), 3), dtype=np.int64)
    for n in np.unique(counts[counts >= 3]):
        chosen = np.flatnonzero(counts == n)
        rows = corners[begin[chosen][:, None] + np.arange(n)]  # (k, n)
        at = place[chosen][:, None] + np.arange(n - 2)  # (k, n - 2)
        out[at] = rows[:, None] if n == 3 else _of_equals(vertices, rows, int(n))
    return out


def of_strip(run: Faces) -> Faces:
    """Return the triangles (n - 2, 3) of a strip of corners (n,), every other one turned round."""
    faces = np.stack([run[:-2], run[1:-1], run[2:]], axis=1)
    faces[1::2] = faces[1::2, ::-1]
    return np.asarray(faces)


def _of_equals(vertices: Array, rows: Faces, n: int) -> Faces:
    """Return the triangles (k, n - 2, 3) of polygons of `n` corners, `rows` (k, n)."""
    fan = np.stack([np.zeros(n - 2, np.int64), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    found = rows[:, fan]
    flat, scale = _seen_flat(vertices[rows])
    turn, pie = (
        _doubled(np.roll(flat, 1, 1), flat, np.roll(flat, -1, 1)),
        _doubled(*flat[:, fan.T].swapaxes(0, 1)),
    )
    least = FLAT * scale
    convex = (turn > least[:, None]).all(axis=1) & (pie > least[:, None]).all(axis=1)
    for k in np.flatnonzero(~convex & (scale > 0)):
        found[k] = rows[k][_ears(flat[k], float(least[k]))]
    return np.asarray(found)


def _seen_flat(points: Array) -> tuple[Array, Array]:
    """Return polygons (k, n, 3) in the plane, anticlockwise (k, n, 2), and their extents squared (k,)."""
    local = points - points[:, :1]
    normal = np.cross(local, np.roll(local, -1, 1)).sum(axis=1)
    axis = np.abs(normal).argmax(axis=1)
    each = np.arange(len(points))
    forward = normal[each, axis] >= 0
    first = np.where(forward, (axis + 1) % 3, (axis + 2) % 3)
    second = np.where(forward, (axis + 2) % 3, (axis + 1) % 3)
    flat = np.stack([local[each, :, first], local[each, :, second]], axis=-1)
    extent = (flat.max(axis=1) - flat.min(axis=1)).max(axis=1)
    return flat, np.where(norms(normal) > 0, extent * extent, 0.0)


def _doubled(a: Array, b: Array, c: Array) -> Array:
    """Return twice the signed area of triangles (..., 2), anticlockwise positive."""
    u, v = b - a, c - a
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _ears(points: Array, least: float) -> Faces:
    """Return the triangles (n - 2, 3) of one polygon (n, 2) that goes round anticlockwise.

    Of the ears the roundest goes first. `least`: twice the area below which a corner is in line. A polygon
    that crosses itself has no ears at some point; its most convex corner is cut off then.
    """
    ring = list(range(len(points)))
    worth = [_ear(points, ring, i, least) for i in range(len(ring))]
    found = []
    while len(ring) > 3:
        best = max(range(len(ring)), key=worth.__getitem__)
        if worth[best] <= 0:  # what was cut off may have freed others
            worth = [_ear(points, ring, i, least) for i in range(len(ring))]
            best = max(range(len(ring)), key=worth.__getitem__)
        if worth[best] <= 0:
            index = np.array(ring)
            best = int(
                _doubled(points[np.roll(index, 1)], points[index], points[np.roll(index, -1)]).argmax()
            )
        found.append((ring[best - 1], ring[best], ring[(best + 1) % len(ring)]))
        del ring[best], worth[best]
        for i in (best - 1, best % len(ring)):
            worth[i] = _ear(points, ring, i % len(ring), least)
    found.append((ring[0], ring[1], ring[2]))
    return np.array(found, dtype=np.int64)


def _ear(points: Array, ring: list[int], i: int, least: float) -> float:
    """Return how round the ear at place `i` of `ring` is, 0 if it is none: area over longest edge squared."""
    a, b, c = points[ring[i - 1]], points[ring[i]], points[ring[(i + 1) % len(ring)]]
    area = float(_doubled(a, b, c))
    if area <= least:
        return 0.0
    others = points[ring]
    inside = (_doubled(a, b, others) >= -least) & (_doubled(b, c, others) >= -least)
    inside &= _doubled(c, a, others) >= -least
    for corner in (a, b, c):
        inside &= (others != corner).any(axis=1)
    if inside.any():
        return 0.0
    return area / max(float(((p - q) ** 2).sum()) for p, q in ((a, b), (b, c), (c, a)))
