"""Mend the surface of a solid that a program has written in pieces.

Corners apart by rounding become one, faces are cut where corners of others lie on their edges, and walls
between touching bricks go. That is tried only where an edge has an odd number of faces, or a face stands
twice: a sound surface is left as it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.geometry.edges import Edges, Rows, components, edges_of
from neve.geometry.files.polygons import triangulated
from neve.reproducible import norms

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

APART = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
"""How far corners may lie apart that were one, in the largest coordinate; the last only if all closes."""
ON_EDGE = 1e-6
"""How far from an edge a corner may lie that is on it, in the largest coordinate."""
MOST_APART = 1e-4
"""And in the size of the whole, which counts where that is far from the origin."""
MOST_NEAR = 100
"""Pairs of near corners for each corner, from which on they are finer than what is to be one."""
MOST_WALLS = 10_000
"""Walls that are taken out one by one."""


def mended(vertices: Array, faces: Faces) -> tuple[Faces, Edges]:
    """Return the faces (k, 3) and edges of a solid of `vertices` (n, 3) and `faces` (m, 3) with areas."""
    edges = edges_of(faces)
    if edges.odd.any():
        faces = _split(vertices, _welded(vertices, faces))
        edges = edges_of(faces)
    once = _once_or_never(faces)
    if once is not faces:
        edges = edges_of(once)
    if not (edges.odd & (edges.counts > 2)).any():
        return once, edges
    faces = _without_walls(vertices, once, edges)
    return faces, edges_of(faces)


def distinct(faces: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first face of each three corners (k,), and how often these stand in `faces` (m, 3)."""
    low, middle, high = np.sort(faces, axis=1).T
    order = np.lexsort((high, middle, low))
    new = np.ones(len(order), dtype=bool)
    for corner in (low, middle, high):
        ordered = corner[order]
        new[1:] &= ordered[1:] == ordered[:-1]
    new[1:] = ~new[1:]
    begin = np.flatnonzero(new)
    return order[begin], np.diff(begin, append=len(order))


def _apart(vertices: Array, faces: Faces, share: float) -> float:
    """Return `share` of the largest coordinate, but no more than MOST_APART of the size of all [m]."""
    used = vertices[np.unique(faces)]
    size = float((used.max(axis=0) - used.min(axis=0)).max())
    return min(share * float(np.abs(used).max()), MOST_APART * size)


def _whole(faces: Faces) -> Faces:
    """Return the faces that have three corners."""
    a, b, c = faces.T
    return np.asarray(faces[(a != b) & (b != c) & (c != a)])


def _welded(vertices: Array, faces: Faces) -> Faces:
    """Return `faces` with corners of open edges as one where they lie so near that fewer edges are open."""
    from scipy.spatial import cKDTree

    edges = edges_of(faces)
    corners = np.unique(edges.ends[edges.odd])
    tree = cKDTree(vertices[corners])
    best, fewest = faces, int(np.count_nonzero(edges.odd))
    for apart in APART:
        within = _apart(vertices, faces, apart)
        if tree.count_neighbors(tree, within) > (2 * MOST_NEAR + 1) * len(corners):
            break
        near = tree.query_pairs(within, output_type="ndarray")
        if not len(near):
            continue
        label = components(near[:, 0], near[:, 1], len(corners))
        _, first = np.unique(label, return_index=True)
        to = np.arange(len(vertices))
        to[corners] = corners[first[label]]
        tried = _whole(to[faces])
        still = int(np.count_nonzero(edges_of(tried).odd)) if len(tried) else fewest
        if still < fewest and (still == 0 or apart < APART[-1]):
            best, fewest = tried, still
        if fewest == 0:
            break
    return best


def _split(vertices: Array, faces: Faces) -> Faces:
    """Return `faces` with those cut whose open edges have corners of other open edges on them."""
    from scipy.spatial import cKDTree

    edges = edges_of(faces)
    open_rows = np.flatnonzero(edges.odd[edges.edge])
    if not len(open_rows):
        return faces
    corners = np.unique(edges.ends[edges.odd])
    a, b = vertices[edges.ends[edges.edge[open_rows]].T]
    near = cKDTree(vertices[corners]).query_ball_point(0.5 * (a + b), 0.5 * norms(b - a) * (1 + 1e-9))
    within = _apart(vertices, faces, ON_EDGE)
    inserted: dict[int, dict[int, list[int]]] = {}
    for row, found, p, q in zip(open_rows.tolist(), near, a, b, strict=True):
        if len(found) <= 2:
            continue
        others = corners[found]
        along = (q - p) / norms(q - p)
        away = vertices[others] - p
        reach = (away * along).sum(axis=1)
        on = (
            (norms(away - reach[:, None] * along) <= within)
            & (reach > within)
            & (reach < norms(q - p) - within)
        )
        if on.any():
            order = np.argsort(reach[on], kind="stable")[:: int(edges.sign[row])]
            inserted.setdefault(row // 3, {})[row % 3] = others[on][order].tolist()
    if not inserted:
        return faces
    rings = []
    for face, sides in inserted.items():
        ring: list[int] = []
        for k in range(3):
            ring += [int(faces[face, k]), *sides.get(k, [])]
        rings.append(ring)
    counts = np.array([len(ring) for ring in rings], dtype=np.int64)
    cut = triangulated(vertices, np.concatenate([np.array(ring, np.int64) for ring in rings]), counts)
    return np.concatenate([np.delete(faces, list(inserted), axis=0), _whole(cut)])


def _once_or_never(faces: Faces) -> Faces:
    """Return `faces` with each that stands several times once, or never if it is a wall between two solids.

    The edge of a wall has an even number of other faces; that of a face that was repeated an odd one. Faces
    that only meet each other are judged together, and stay if nothing speaks against it.
    """
    first, counts = distinct(faces)
    if (counts == 1).all():
        return faces
    single = faces[np.sort(first[counts == 1])]
    repeated = faces[np.sort(first[counts > 1])]
    both = edges_of(np.concatenate([single, repeated]))
    of_single = both.face < len(single)
    others = np.bincount(both.edge[of_single], minlength=len(both.ends))
    rows = np.flatnonzero(~of_single)
    label = _joined(both.face[rows] - len(single), both.edge[rows], others % 2 == 0, len(repeated))
    alone = np.bincount(both.edge[rows], minlength=len(both.ends))[both.edge[rows]] == 1
    met = others[both.edge[rows]]
    vote = np.where(met % 2 == 1, 1, np.where(met > 0, -1, 0)) * alone
    votes = np.bincount(label[both.face[rows] - len(single)], vote, int(label.max()) + 1)
    kept = np.zeros(len(faces), dtype=bool)
    kept[first[counts == 1]] = True
    kept[np.sort(first[counts > 1])[votes[label] >= 0]] = True
    return np.asarray(faces[kept])


def _joined(face: Rows, edge: Rows, joins: NDArray[np.bool_], count: int) -> NDArray[np.int32]:
    """Return a label for each of `count` faces: the same where they meet at an edge that `joins`."""
    chosen = joins[edge]
    return components(face[chosen], count + edge[chosen], count + len(joins))[:count]


def _without_walls(vertices: Array, faces: Faces, edges: Edges) -> Faces:
    """Return `faces` without the parts on whose border everywhere an odd number of faces meet.

    That is three or more. Of all such parts the smallest goes first, until none is left: between two solids
    that were joined into one that is the wall.
    """
    label = _joined(edges.face, edges.edge, edges.counts == 2, len(faces))
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.bincount(label, norms(np.cross(b - a, c - a)))
    counts = edges.counts.copy()
    border = edges.counts[edges.edge] != 2
    rows = np.flatnonzero(border)
    rows = rows[np.argsort(label[edges.face[rows]], kind="stable")]
    parts, begin = np.unique(label[edges.face[rows]], return_index=True)
    borders = dict(zip(parts.tolist(), np.split(edges.edge[rows], begin[1:]), strict=True))
    gone = np.zeros(int(label.max()) + 1, dtype=bool)
    for part in sorted(borders, key=lambda part: area[part])[:MOST_WALLS]:
        at = borders[part]
        if ((counts[at] % 2 == 1) & (counts[at] > 2)).all():
            gone[part] = True
            np.subtract.at(counts, at, 1)
    return np.asarray(faces[~gone[label]])
