"""Turn a field into a closed triangle mesh with sharp edges: dual contouring on a regular grid.

Source: Ju, Losasso, Schaefer & Warren 2002, "Dual contouring of Hermite data", SIGGRAPH, section 2: one
vertex in each cell that the surface crosses, at the place nearest to the planes that touch the surface
where it crosses the cell's edges; one face of four vertices around each such edge.
"""

from __future__ import annotations

import numpy as np
from implicit import Array, Field, slope
from numpy.typing import NDArray

Faces = NDArray[np.int64]


def contour(field: Field, low: tuple, high: tuple, spacing: float) -> tuple[Array, Faces]:
    """Return vertices (n, 3) [m] and triangles (m, 3) of the surface where the field is zero.

    low, high: corners of a box that holds the whole surface [m]; spacing: of the grid [m].
    """
    size = np.ceil(np.subtract(high, low) / spacing).astype(int) + 1
    origin = np.asarray(low, float)
    corner = np.stack(np.meshgrid(*map(np.arange, size), indexing="ij"), -1).reshape(-1, 3)
    solid = _simple((field(origin + spacing * corner) < 0.0).reshape(size))
    crossings = [_crossings(field, solid, origin, spacing, axis) for axis in range(3)]
    vertices, index = _place(crossings, size - 1, origin, spacing)
    faces = [_faces(crossing, index, vertices) for crossing in crossings]
    return vertices, np.concatenate(faces)


def _simple(solid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Fill corners until no face of a cell has solid corners on one diagonal only, and no cell on a space
    diagonal only: then every cell holds one piece of surface, and the mesh is a manifold."""
    solid = solid.copy()
    while True:
        before = int(solid.sum())
        for axis in range(3):
            s = np.moveaxis(solid, axis, 2)
            a, b, c, d = s[:-1, :-1], s[1:, :-1], s[:-1, 1:], s[1:, 1:]
            one, other = a & d & ~b & ~c, b & c & ~a & ~d
            b |= one
            a |= other
        c = [
            solid[i : i - 1 or None, j : j - 1 or None, k : k - 1 or None] for i, j, k in np.ndindex(2, 2, 2)
        ]
        count = np.sum(c, axis=0)
        for n in range(8):
            lone = c[n] & c[7 - n] & (count == 2)
            c[n ^ 1][lone], c[n ^ 3][lone] = True, True
            gap = ~c[n] & ~c[7 - n] & (count == 6)
            c[n][gap] = True
        if int(solid.sum()) == before:
            return solid


def _crossings(
    field: Field, solid: NDArray[np.bool_], origin: Array, spacing: float, axis: int
) -> tuple[int, Faces, NDArray[np.bool_], Array, Array]:
    """Return axis, lower corner (n, 3), whether that is solid, point and normal of each crossed edge."""
    ahead = [slice(None)] * 3
    behind = [slice(None)] * 3
    ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
    lower = np.argwhere(solid[tuple(ahead)] != solid[tuple(behind)])
    start = origin + spacing * lower
    step = spacing * np.eye(3)[axis]
    inside = solid[tuple(lower.T)]
    near, far = np.zeros(len(lower)), np.ones(len(lower))
    for _ in range(12):  # halve the edge; a corner filled by `_simple` leaves the crossing at its own end
        middle = 0.5 * (near + far)
        same = (field(start + middle[:, None] * step) < 0.0) == inside
        near, far = np.where(same, middle, near), np.where(same, far, middle)
    point = start + (0.5 * (near + far))[:, None] * step
    return axis, lower, inside, point, slope(field, point, 0.02 * spacing)


def _around(lower: Faces, axis: int) -> list[Faces]:
    """Return the four cells around each edge, in turning order about the axis."""
    u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
    return [lower - u - v, lower - v, lower, lower - u]


def _place(crossings: list, cells: Array, origin: Array, spacing: float) -> tuple[Array, Faces]:
    """Return one vertex per crossed cell and the vertex number of every cell (-1: none)."""
    where, points, normals = [], [], []
    for axis, lower, _, point, normal in crossings:
        for cell in _around(lower, axis):
            where.append(np.ravel_multi_index(tuple(cell.T), tuple(cells)))
            points.append(point)
            normals.append(normal)
    cell, of_sample = np.unique(np.concatenate(where), return_inverse=True)
    p, n = np.concatenate(points), np.concatenate(normals)
    count = np.bincount(of_sample).astype(float)
    middle = _sums(of_sample, p) / count[:, None]
    away = np.sum(n * (p - middle[of_sample]), axis=1)
    A = _sums(of_sample, (n[:, :, None] * n[:, None, :]).reshape(-1, 9)).reshape(-1, 3, 3)
    b = _sums(of_sample, n * away[:, None])
    values, vectors = np.linalg.eigh(A)
    kept = values > 0.08 * values[:, 2:]  # weaker directions are noise of a smooth surface
    turned = np.einsum("cij,ci->cj", vectors, b) * np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)
    x = middle + np.einsum("cij,cj->ci", vectors, turned)
    low = origin + spacing * np.stack(np.unravel_index(cell, tuple(cells)), -1)
    x = np.clip(x, low + 0.02 * spacing, low + 0.98 * spacing)
    index = np.full(int(np.prod(cells)), -1)
    index[cell] = np.arange(len(cell))
    return x, index.reshape(tuple(cells))


def _sums(group: Faces, values: Array) -> Array:
    return np.stack([np.bincount(group, column) for column in values.T], -1)


def _faces(crossing: tuple, index: Faces, vertices: Array) -> Faces:
    """Return two triangles for each crossed edge, cut along the diagonal that follows the surface."""
    axis, lower, inside, _, normal = crossing
    quad = np.stack([index[tuple(cell.T)] for cell in _around(lower, axis)], -1)
    quad[~inside] = quad[~inside][:, ::-1]
    cuts = [((0, 1, 2), (0, 2, 3)), ((1, 2, 3), (1, 3, 0))]
    worst = []
    for cut in cuts:
        facing = []
        for triangle in cut:
            a, b, c = (vertices[quad[:, corner]] for corner in triangle)
            n = np.cross(b - a, c - a)
            facing.append(np.sum(n * normal, axis=1) / np.maximum(np.linalg.norm(n, axis=1), 1e-30))
        worst.append(np.minimum(*facing))
    second = worst[1] > worst[0]
    out = [np.where(second[:, None], quad[:, cuts[1][t]], quad[:, cuts[0][t]]) for t in range(2)]
    return np.concatenate(out)
