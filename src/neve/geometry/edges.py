"""Edges of triangles: which faces meet at each, and which two of them go on from one to the other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import norms

Array = NDArray[np.float64]
Indices = NDArray[np.int32]
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Edges:
    """Hold the edges of triangles; each face has a row for each of its three.

    Attributes:
        face: of each row (3 m,)
        edge: which edge it is (3 m,)
        sign: 1 if the face runs along it from the lower to the higher corner, else -1 (3 m,)
        ends: lower and higher corner of each edge (n, 2)
    """

    face: Rows
    edge: Rows
    sign: Rows
    ends: Rows

    @cached_property
    def counts(self) -> Rows:
        """How many faces meet at each edge (n,)."""
        return np.bincount(self.edge, minlength=len(self.ends))

    @cached_property
    def unbalanced(self) -> NDArray[np.bool_]:
        """Whether faces run along each edge more often one way than the other (n,)."""
        return np.asarray(np.bincount(self.edge, weights=self.sign, minlength=len(self.ends)) != 0)

    @cached_property
    def odd(self) -> NDArray[np.bool_]:
        """Whether an odd number of faces meets at each edge, so that it cannot be closed (n,)."""
        return np.asarray(self.counts % 2 == 1)

    def rows_of(self, chosen: NDArray[np.bool_]) -> tuple[Rows, Rows]:
        """Return the rows of the `chosen` edges, edge by edge, and where each edge begins among them."""
        rows = np.flatnonzero(chosen[self.edge])
        rows = rows[np.argsort(self.edge[rows], kind="stable")]
        begin = np.flatnonzero(np.diff(self.edge[rows], prepend=-1))
        return rows, begin


def edges_of(faces: NDArray[np.integer]) -> Edges:
    """Return the edges of `faces` (m, 3)."""
    begin, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    low, high = np.minimum(begin, end).astype(np.int64), np.maximum(begin, end).astype(np.int64)
    wide = int(faces.max()) + 1 if len(faces) else 1
    keys, edge = np.unique(low * wide + high, return_inverse=True)
    ends = np.stack([keys // wide, keys % wide], axis=1)
    face = np.repeat(np.arange(len(faces)), 3)
    return Edges(face, edge.reshape(-1), np.where(begin < end, 1, -1), ends)


def pairs(vertices: Array, faces: NDArray[np.integer], edges: Edges) -> tuple[Rows, Rows]:
    """Return two rows of `edges` for each two faces (p,), (p,) that go on from one to the other at an edge.

    Where more than two meet, first those are paired that hang together elsewhere. The rest are taken in
    their order around the edge: of neighbours that run along it in opposite directions, pairs as of brackets;
    what is left over, all of one direction, is paired in order. So each of several solids that touch at an
    edge keeps its own faces, whichever of them is inside out.
    """
    rows, _ = edges.rows_of(edges.counts == 2)
    first, second = rows[0::2], rows[1::2]
    many = edges.counts > 2
    if not many.any():
        return first, second
    part = components(edges.face[first], edges.face[second], len(faces))
    rows, begin = _around(vertices, faces, edges, many, part)
    a: list[int] = []
    b: list[int] = []
    for run in np.split(rows, begin[1:]):
        _pair(run.tolist(), edges.sign[run].tolist(), part[edges.face[run]].tolist(), a, b)
    return np.concatenate([first, np.array(a, np.int64)]), np.concatenate([second, np.array(b, np.int64)])


def _pair(run: list[int], sign: list[int], part: list[int], a: list[int], b: list[int]) -> None:
    """Append to `a` and `b` the pairs of one edge, whose rows `run` lie in their order around it."""
    met: dict[int, list[int]] = {}
    for i, of in enumerate(part):
        met.setdefault(of, []).append(i)
    free = set(range(len(run)))
    for own in met.values():
        if len(own) == 2 and sign[own[0]] != sign[own[1]]:
            a.append(run[own[0]])
            b.append(run[own[1]])
            free -= {*own}
    waiting: list[int] = []
    for i in sorted(free):
        if waiting and sign[waiting[-1]] != sign[i]:
            a.append(run[waiting.pop()])
            b.append(run[i])
        else:
            waiting.append(i)
    for i, j in zip(waiting[0::2], waiting[1::2], strict=False):
        a.append(run[i])
        b.append(run[j])


def _around(
    vertices: Array,
    faces: NDArray[np.integer],
    edges: Edges,
    chosen: NDArray[np.bool_],
    part: NDArray[np.int32],
) -> tuple[Rows, Rows]:
    """Return the rows of the `chosen` edges, edge by edge and by the angle of the face around the edge.

    Faces in one plane are taken as if they lay apart along its normal, in the order of their `part` (m,).
    """
    rows, _ = edges.rows_of(chosen)
    edge = edges.edge[rows]
    origin = vertices[edges.ends[edge, 0]]
    along = vertices[edges.ends[edge, 1]] - origin
    along /= norms(along)[:, None]
    third = faces[edges.face[rows], (rows % 3 + 2) % 3]
    away = vertices[third] - origin
    axis = np.abs(along).argmin(axis=1)
    right = np.cross(along, np.eye(3)[axis])
    up = np.cross(along, right)
    length = norms(right)
    x, y = (away * right).sum(axis=1) / length, (away * up).sum(axis=1) / length
    part_of_turn = y / (np.abs(x) + np.abs(y))  # grows with the angle: 0 to 4 around
    angle = np.where(x < 0, 2.0 - part_of_turn, np.where(y < 0, 4.0 + part_of_turn, part_of_turn))
    angle = np.round(angle, 7) % 4.0
    ahead = np.cross(along, away)  # where the angle grows
    steep = np.abs(ahead).argmax(axis=1)
    up_or_down = np.sign(ahead[np.arange(len(rows)), steep]).astype(np.int64)
    order = np.lexsort((part[edges.face[rows]] * up_or_down, angle, edge))
    rows = rows[order]
    return rows, np.flatnonzero(np.diff(edges.edge[rows], prepend=-1))


def components(f: Rows, g: Rows, count: int) -> NDArray[np.int32]:
    """Return a label for each of `count` things (count,): the same where f (n,) and g (n,) join them."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(f), np.int8), (f, g)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])
