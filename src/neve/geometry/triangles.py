"""Triangles: the surface of a solid as vertices and faces, put in order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.geometry.edges import components, edges_of
from neve.geometry.mending import distinct, mended
from neve.geometry.shells import oriented
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
    def closed_volume(self) -> float:
        """Volume inside once every hole is closed by a cone from the middle of its rim [m3].

        That of the surface itself if it is closed; exact if each hole is flat.
        """
        edges = edges_of(self.faces)
        balance = np.bincount(edges.edge, weights=edges.sign, minlength=len(edges.ends))
        rim = np.flatnonzero(balance)
        if not len(rim):
            return self.volume
        ends, times = edges.ends[rim], balance[rim]
        corners, rows = np.unique(ends, return_inverse=True)
        rows = rows.reshape(-1, 2)
        hole = components(rows[:, 0], rows[:, 1], len(corners))
        held = np.bincount(hole)[:, None]
        middles = np.stack([np.bincount(hole, self.vertices[corners, k]) for k in range(3)], axis=1) / held
        middle = 0.5 * (self.low + self.high)
        a, b = self.vertices[ends[:, 0]] - middle, self.vertices[ends[:, 1]] - middle
        tip = middles[hole[rows[:, 0]]] - middle
        return self.volume - float(np.sum(times * np.sum(np.cross(a, b) * tip, axis=1))) / 6.0

    @cached_property
    def open_edges(self) -> int:
        """Number of edges that faces do not run along equally often in both directions; 0 if closed.

        A surface without such edges has no boundary, so that its winding number is a whole number anywhere.
        """
        return int(np.count_nonzero(edges_of(self.faces).unbalanced))

    @cached_property
    def parts(self) -> NDArray[np.int32]:
        """Which part each face is of (m,): parts hang together at edges of two faces."""
        edges = edges_of(self.faces)
        rows, _ = edges.rows_of(edges.counts == 2)
        return components(edges.face[rows[0::2]], edges.face[rows[1::2]], len(self.faces))

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


def tidied(vertices: Array, faces: NDArray[np.integer], sheet: bool = False) -> Triangles:
    """Return a surface of `vertices` [m] (n, 3) and `faces` (m, 3) in order.

    Equal vertices become one; faces that are lines or points go, and repeated ones. Of a solid, that is no
    `sheet`, what is open by rounding is closed and walls between touching parts go (`neve.geometry.mending`).
    Faces that hang together face the same side, each closed part its own outside (`neve.geometry.shells`).
    """
    unique, rows = _distinct(vertices + 0.0)  # -0.0 + 0.0 is 0.0
    corners = rows[faces].reshape(-1, 3)
    corners = corners[_has_area(unique, corners)]
    if not len(corners):
        return Triangles(unique[:0], corners.astype(np.int32))
    if sheet:
        corners = corners[np.sort(distinct(corners)[0])]
        edges = edges_of(corners)
    else:
        corners, edges = mended(unique, corners)
    used, rows = np.unique(corners, return_inverse=True)
    place = np.cumsum(np.isin(np.arange(len(unique)), used, assume_unique=True)) - 1
    found = np.ascontiguousarray(unique[used])
    indices = np.ascontiguousarray(rows.reshape(-1, 3).astype(np.int32))
    return Triangles(found, oriented(found, indices, replace(edges, ends=place[edges.ends])))


def _distinct(vertices: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return the distinct rows of `vertices` in order (k, 3), and which of them each is (n,)."""
    order = np.lexsort(vertices.T[::-1])
    ordered = vertices[order]
    new = np.ones(len(vertices), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    rows = np.empty(len(vertices), dtype=np.int64)
    rows[order] = np.cumsum(new) - 1
    return ordered[new], rows


def _has_area(vertices: Array, faces: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Return whether each face is more than a line: its height is above rounding of its longest edge."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    longest = np.maximum.reduce([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))])
    double_area = norms(np.cross(b - a, c - a))
    return np.asarray(double_area > 1e-12 * longest)
