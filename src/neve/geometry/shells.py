"""Shells: which faces of a surface hang together, and which way each shell must look.

A shell that lies beside all others looks outward. One inside another is a hollow of it where the file turned
the two against each other, and a solid in it where both look the same way. Where faces of one shell look
different ways, the file says nothing of it, and it is a hollow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.geometry.edges import Edges, Rows, components, pairs
from neve.reproducible import norms

Array = NDArray[np.float64]
Indices = NDArray[np.int32]

NO_VOLUME = 1e-9
"""Of a shell of area A: what is below this times A^(3/2) is rounding."""
GAPING = 0.02
"""Share of a shell's area that its area vectors may add up to, if it is closed but for small holes."""
LOOKED_AT = 64
"""Faces of a shell, below which points are looked for in others."""
NEAR_CORNER = 0.98
"""Share of the way from the middle of a face to its corners at which such points lie."""


def oriented(vertices: Array, faces: Indices, edges: Edges) -> Indices:
    """Return `faces` (m, 3), of these `edges`, with each closed shell turned the way it must look.

    First faces that go on from one to the other are made to agree; see `neve.geometry.edges.pairs`.
    """
    first, second = pairs(vertices, faces, edges)
    f, g = edges.face[first], edges.face[second]
    faces, unsure = _agreeing(vertices, faces, f, g, edges.sign[first] == edges.sign[second])
    shells = _shells(vertices, faces, edges, f, g)
    turned = _turned(vertices, faces, shells, np.unique(shells[unsure]))
    return np.ascontiguousarray(np.where(turned[shells][:, None], faces[:, ::-1], faces))


def _shares(
    vertices: Array, faces: Indices, label: NDArray[np.integer], count: int
) -> tuple[Array, Array, Array]:
    """Return volume [m3], area [m2] and sum of area vectors [m2] of the faces of each label."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    vectors = 0.5 * np.cross(b - a, c - a)
    middles = (a + b + c) / 3.0
    held = np.maximum(np.bincount(label, minlength=count), 1)[:, None]
    center = np.stack([np.bincount(label, middles[:, k], count) for k in range(3)], axis=1) / held
    volume = np.bincount(label, np.sum((middles - center[label]) * vectors, axis=1) / 3.0, count)
    gap = np.stack([np.bincount(label, vectors[:, k], count) for k in range(3)], axis=1)
    area = np.bincount(label, norms(vectors), count)
    return np.asarray(volume, np.float64), np.asarray(area), np.asarray(gap, np.float64)


def _agreeing(
    vertices: Array, faces: Indices, f: Rows, g: Rows, against: NDArray[np.bool_]
) -> tuple[Indices, NDArray[np.bool_]]:
    """Return `faces` turned round so that paired ones run along their edge in opposite directions.

    Every face stands twice in a graph, as it is and turned round; paired faces are joined so that they agree.
    The two copies of a connected part then fall into two components, unless the part has one side only. A
    part whose faces agreed keeps its orientation; of another, the component with the larger volume is kept.
    Returns also whether each face is of such a part (m,).
    """
    if not against.any():
        return faces, np.zeros(len(faces), dtype=bool)
    m = len(faces)
    column = np.concatenate([np.where(against, g + m, g), np.where(against, g, g + m)])
    label = components(np.concatenate([f, f + m]), column, 2 * m)
    kept, turned = label[:m], label[m:]
    count = int(label.max()) + 1
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    share = np.sum(((a + b + c) / 3.0 - middle) * np.cross(b - a, c - a), axis=1)
    volume = np.bincount(kept, share, count) - np.bincount(turned, share, count)
    disagrees = np.zeros(count, dtype=bool)
    disagrees[label[np.concatenate([f[against], f[against] + m])]] = True
    flip = disagrees[kept] & (volume[turned] > volume[kept])
    return np.where(flip[:, None], faces[:, ::-1], faces), disagrees[kept]


def _shells(vertices: Array, faces: Indices, edges: Edges, f: Rows, g: Rows) -> NDArray[np.int32]:
    """Return the shell of each face (m,): parts that hang together, and all that gape as one."""
    label = components(f, g, len(faces))
    count = int(label.max()) + 1
    if count == 1 or not edges.odd.any():
        return label
    _, area, gap = _shares(vertices, faces, label, count)
    gapes = norms(gap) > GAPING * area
    if np.count_nonzero(gapes) > 1:
        label = np.where(gapes[label], count, label)
        label = np.unique(label, return_inverse=True)[1].reshape(-1).astype(np.int32)
    return label


def _turned(
    vertices: Array, faces: Indices, label: NDArray[np.int32], unsure: NDArray[np.integer]
) -> NDArray[np.bool_]:
    """Return whether each shell must be turned round (n,); of the `unsure` ones the file says nothing."""
    count = int(label.max()) + 1
    volume, area, _ = _shares(vertices, faces, label, count)
    inward = volume < -NO_VOLUME * area * np.sqrt(area)
    if count == 1 or (not inward.any() and not len(unsure)):
        return np.asarray(inward)
    within = _within(vertices, faces, label, np.abs(volume))
    sign = np.where(inward, -1, 1)
    turned = np.zeros(count, dtype=bool)
    is_unsure = np.isin(np.arange(count), unsure)
    around = np.zeros(count, dtype=np.int64)  # how often the finished shells wind round each from outside
    size = np.abs(volume)
    for shell in np.argsort(-size, kind="stable").tolist():
        holders = within.get(shell, [])
        if not holders or around[shell] <= 0:
            turned[shell] = inward[shell]
        else:
            outermost = max(holders, key=lambda other: size[other])
            sure = not (is_unsure[shell] or is_unsure[outermost])
            turned[shell] = turned[outermost] if sure else not inward[shell]
        for other, theirs in within.items():
            if shell in theirs:
                around[other] += -sign[shell] if turned[shell] else sign[shell]
    return turned


def _within(vertices: Array, faces: Indices, label: NDArray[np.int32], size: Array) -> dict[int, list[int]]:
    """Return for each shell that lies inside larger ones which those are."""
    count = len(size)
    order = np.argsort(label, kind="stable")
    runs = np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1])
    low = np.array([vertices[faces[run]].min(axis=(0, 1)) for run in runs])
    high = np.array([vertices[faces[run]].max(axis=(0, 1)) for run in runs])
    room = 1e-9 * (high - low).max(axis=1)[:, None]
    found: dict[int, list[int]] = {}
    trees: dict[int, _core.TriangleMesh] = {}
    for shell in range(count):
        fits = (low <= low[shell] + room) & (high >= high[shell] - room)
        candidates = np.flatnonzero(fits.all(axis=1) & (size > size[shell]))
        if not len(candidates):
            continue
        points = _inner_points(vertices, faces[runs[shell]])
        for other in candidates.tolist():
            if other not in trees:
                used, rows = np.unique(faces[runs[other]], return_inverse=True)
                own: Indices = np.ascontiguousarray(rows.reshape(-1, 3), dtype=np.int32)
                trees[other] = _core.geometry.TriangleMesh(vertices[used], own)
            if (np.abs(trees[other].winding(points, exact=len(runs[other]) < 10_000)) > 0.5).all():
                found.setdefault(shell, []).append(other)
    return found


def _inner_points(vertices: Array, faces: Indices) -> Array:
    """Return points (n, 3) just inside a shell, below the middles and near the corners of LOOKED_AT faces.

    Half of these are the largest ones, the others any.
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    vectors = 0.5 * np.cross(b - a, c - a)
    area = norms(vectors)
    volume = float(np.sum((a - a[0]) * vectors)) / 3.0
    most = LOOKED_AT // 2
    chosen = np.unique(
        [*np.argsort(-area, kind="stable")[:most], *range(0, len(area), len(area) // most + 1)]
    )
    depth = np.minimum(1e-3 * np.sqrt(area[chosen]), abs(volume) / area.sum())
    below = (-np.copysign(1.0, volume) * depth / area[chosen])[:, None] * vectors[chosen]
    middle = (a + b + c)[chosen] / 3.0
    seen = [middle, *(NEAR_CORNER * p[chosen] + (1 - NEAR_CORNER) * middle for p in (a, b, c))]
    return np.ascontiguousarray(np.concatenate([point + below for point in seen]))
