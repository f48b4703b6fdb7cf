"""Triangles: the surface of a solid as vertices and faces, put in order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.reproducible import norms

if TYPE_CHECKING:
    from neve._core import TriangleMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Triangles:
    """Hold a surface; seen from outside, the corners of a face go round anticlockwise.

    Attributes:
        vertices: corners [m], (n, 3)
        faces: rows of `vertices`, (m, 3)
    """

    vertices: Array
    faces: Indices

    @cached_property
    def low(self) -> Array:
        """Least coordinates [m] (3,)."""
        return np.asarray(self.vertices.min(axis=0))

    @cached_property
    def high(self) -> Array:
        """Largest coordinates [m] (3,)."""
        return np.asarray(self.vertices.max(axis=0))

    @cached_property
    def area_vectors(self) -> Array:
        """Normal of each face times its area [m2] (m, 3)."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return np.asarray(0.5 * np.cross(b - a, c - a))

    @cached_property
    def area(self) -> float:
        """Area of the surface [m2]."""
        return float(norms(self.area_vectors).sum())

    @cached_property
    def volume(self) -> float:
        """Volume inside [m3], by the divergence theorem: sum of x . A / 3 over the faces.

        Exact where the surface is closed; parts inside one another count each by itself, with the sign of
        their orientation. Measured from the middle, which keeps the error of an open surface small.
        """
        middles = self.vertices[self.faces].mean(axis=1) - 0.5 * (self.low + self.high)
        return float(np.sum(middles * self.area_vectors) / 3.0)

    @cached_property
    def open_edges(self) -> int:
        """Number of edges that faces do not run along equally often in both directions; 0 if closed.

        A surface without such edges has no boundary, so that its winding number is a whole number anywhere.
        """
        _, edge, sign = _edges(self.faces)
        return int(np.count_nonzero(np.bincount(edge, weights=sign)))

    @cached_property
    def spans(self) -> tuple[Array, Array]:
        """Longest edge of each face, and the height of the face above it [m], each (m,)."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        longest = np.maximum.reduce([norms(p - q) for p, q in ((a, b), (b, c), (c, a))])
        return longest, 2.0 * norms(self.area_vectors) / longest

    @cached_property
    def tree(self) -> TriangleMesh:
        """The core's own, which finds near triangles, hits of rays and winding numbers quickly."""
        return _core.geometry.TriangleMesh(self.vertices, self.faces)

    def flipped(self) -> Triangles:
        """Return the surface turned inside out."""
        return replace(self, faces=np.ascontiguousarray(self.faces[:, ::-1]))


def tidied(vertices: Array, faces: NDArray[np.integer]) -> Triangles:
    """Return a surface of `vertices` [m] (n, 3) and `faces` (m, 3) in order.

    Equal vertices become one; faces that are lines or points, and repeated ones, go; faces of a
    connected part face the same side, the outside where neighbours disagreed; and so does the whole.
    """
    unique, rows = np.unique(vertices + 0.0, axis=0, return_inverse=True)  # -0.0 + 0.0 is 0.0
    corners = rows.reshape(-1)[faces].astype(np.int32).reshape(-1, 3)
    corners = corners[_has_area(unique, corners)]
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    corners = corners[np.sort(first)]
    used, corners = np.unique(corners, return_inverse=True)
    found = Triangles(np.ascontiguousarray(unique[used]), corners.reshape(-1, 3).astype(np.int32))
    if len(found.faces):
        found = _agreeing(found)
        found = found.flipped() if found.volume < 0 else found
    return found


def _has_area(vertices: Array, faces: Indices) -> NDArray[np.bool_]:
    """Return whether each face is more than a line: its height is above rounding of its longest edge."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    longest = np.maximum.reduce([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))])
    double_area = norms(np.cross(b - a, c - a))
    return np.asarray(double_area > 1e-12 * longest)


def _edges(faces: Indices) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.int64]]:
    """Return for the three edges of each face the face, the edge, and its direction, 1 or -1."""
    begin, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    low, high = np.minimum(begin, end).astype(np.int64), np.maximum(begin, end).astype(np.int64)
    _, edge = np.unique(low * (int(faces.max()) + 1) + high, return_inverse=True)
    return np.repeat(np.arange(len(faces)), 3), edge.reshape(-1), np.where(begin < end, 1, -1)


def _agreeing(surface: Triangles) -> Triangles:
    """Return `surface` with faces turned round so that two on one edge run along it in opposite directions.

    Every face stands twice in a graph, as it is and turned round; faces on a common edge are joined so that
    they agree. The two copies of a connected part then fall into two components, unless the part has one side
    only. A part whose faces agreed keeps its orientation, so that cavities stay cavities; of another, the
    component with the larger volume is kept.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    face, edge, sign = _edges(surface.faces)
    pairs = np.argsort(edge, kind="stable")
    count = np.bincount(edge)
    pairs = pairs[np.isin(edge[pairs], np.flatnonzero(count == 2))].reshape(-1, 2)
    (f, g), against = face[pairs].T, sign[pairs[:, 0]] == sign[pairs[:, 1]]
    if not against.any():
        return surface
    m = len(surface.faces)
    row = np.concatenate([f, f + m])
    column = np.concatenate([np.where(against, g + m, g), np.where(against, g, g + m)])
    graph = coo_array((np.ones(len(row), np.int8), (row, column)), shape=(2 * m, 2 * m))
    _, label = connected_components(graph, directed=False)
    kept, turned = label[:m], label[m:]
    middle = 0.5 * (surface.low + surface.high)
    share = np.sum((surface.vertices[surface.faces].mean(axis=1) - middle) * surface.area_vectors, axis=1)
    volume = np.bincount(kept, share, label.max() + 1) - np.bincount(turned, share, label.max() + 1)
    disagrees = np.zeros(label.max() + 1, dtype=bool)
    disagrees[label[np.concatenate([f[against], f[against] + m])]] = True
    flip = disagrees[kept] & (volume[turned] > volume[kept])
    faces = np.where(flip[:, None], surface.faces[:, ::-1], surface.faces)
    return replace(surface, faces=np.ascontiguousarray(faces))
