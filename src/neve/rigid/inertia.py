"""Weigh bodies: volume, centre of mass and moments of inertia of a shape that is filled evenly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.solid import Solid
from neve.geometry.inside import volume as volume_inside
from neve.geometry.inside import windings
from neve.geometry.triangles import Triangles
from neve.reproducible import eigen, norms
from neve.scene.errors import SceneError

Array = NDArray[np.float64]

CELLS = 64
"""Cells along each edge of the box around a mesh whose triangles give no integrals, see `of_inside`."""

FAR_OFF = 0.3
"""Share of the counted volume by which that of the triangles may differ from it."""


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Hold the mass properties of a shape of density 1, in its own frame.

    Attributes:
        volume: [m3]
        center: centre of mass [m], (3,)
        inertia: moments of inertia about the centre of mass for density 1 [m5], (3, 3), symmetric
    """

    volume: float
    center: Array
    inertia: Array

    def principal(self) -> tuple[Array, Array]:
        """Return the principal moments (3,) and the right-handed matrix (3, 3) of their axes, in columns."""
        off = self.inertia - np.diag(np.diag(self.inertia))
        if np.abs(off).max() <= 1e-12 * np.trace(self.inertia):
            return np.diag(self.inertia).copy(), np.eye(3)
        return eigen(self.inertia)


def mass_properties(solid: Solid) -> MassProperties:
    """Return volume, centre of mass and inertia of a solid that has bounds.

    Errors: SceneError for a mesh without an inside.
    """
    if solid.mesh:
        if solid.mesh.thickness > 0:
            return of_sheet(solid.mesh.vertices, solid.mesh.faces, solid.mesh.thickness)
        if not _winds_once(solid.mesh.surface):
            return of_inside(solid.mesh.surface, solid.name)
        return of_mesh(solid.mesh.vertices, solid.mesh.faces)
    if solid.endless:
        raise ValueError(f"{solid.name}: a {solid.shape} has no mass")
    volume, squares = solid.form.volume_of(solid.half), solid.form.mean_squares(solid.half)
    return MassProperties(volume, np.zeros(3), volume * np.diag(squares.sum() - squares))


def _winds_once(surface: Triangles) -> bool:
    """Whether sums over the triangles are integrals over the inside: closed, no overlaps, none inside out."""
    return not surface.open_edges and bool(np.all(windings(surface, surface.low, surface.high, 24)[1] == 1))


def of_mesh(vertices: NDArray[Any], faces: NDArray[Any]) -> MassProperties:
    """Return volume, centre of mass and inertia inside a closed triangle mesh: vertices (n, 3), faces (m, 3).

    Sums over the tetrahedra between each face and one point, signed by the side on which the face looks at
    it; with corners a, b, c from that point, s = a + b + c and V = a . (b x c) / 6 the integrals are
    int 1 = V, int x = V s / 4, int x x^T = V (a a^T + b b^T + c c^T + s s^T) / 20. A mesh that is inside out
    weighs the same.
    """
    v = np.asarray(vertices, dtype=np.float64)
    origin = v.mean(axis=0)  # near the body, so that sums of large numbers do not cancel
    a, b, c = (v[np.asarray(faces)[:, i]] - origin for i in range(3))
    s = a + b + c
    V = np.sum(a * np.cross(b, c), axis=1) / 6.0
    volume = float(V.sum())
    sign = math.copysign(1.0, volume)
    center = (V[:, None] * s).sum(axis=0) / (4.0 * volume)
    second = sum(_squares(V, p) for p in (a, b, c, s)) / 20.0
    second = sign * (second - volume * np.outer(center, center))
    return MassProperties(abs(volume), origin + center, np.trace(second) * np.eye(3) - second)


def of_sheet(vertices: NDArray[Any], faces: NDArray[Any], thickness: float) -> MassProperties:
    """Return volume, centre of mass and inertia of a sheet around triangles: area times `thickness` [m].

    Over a triangle of area A with corners a, b, c and s = a + b + c: int x = A s / 3, int x x^T =
    A (a a^T + b b^T + c c^T + s s^T) / 12; across it, n n^T A t^2 / 12. Edges and folds are left out.
    """
    v = np.asarray(vertices, dtype=np.float64)
    origin = v.mean(axis=0)
    a, b, c = (v[np.asarray(faces)[:, i]] - origin for i in range(3))
    s = a + b + c
    across = 0.5 * np.cross(b - a, c - a)
    A = norms(across)
    area = float(A.sum())
    center = (A[:, None] * s).sum(axis=0) / (3.0 * area)
    second = sum(_squares(A, p) for p in (a, b, c, s)) / 12.0
    second += _squares(1.0 / A, across) * thickness**2 / 12.0
    second = thickness * (second - area * np.outer(center, center))
    return MassProperties(thickness * area, origin + center, np.trace(second) * np.eye(3) - second)


def _squares(weights: Array, x: Array) -> Array:
    """Return sum w x x^T (3, 3) of weights (n,) and vectors (n, 3)."""
    return np.array([[np.sum(weights * x[:, i] * x[:, j]) for j in range(3)] for i in range(3)])


def of_inside(surface: Triangles, name: str) -> MassProperties:
    """Return volume, centre of mass and inertia of where `surface` winds round.

    For triangles whose sums are no integrals: of pieces that overlap, or with small holes. Sums over CELLS^3
    cells of the box around it, each whole or not at all, scaled to the volume that the triangles tell.

    Errors: SceneError if there is no inside; `name`: used in messages.
    """
    size = surface.high - surface.low
    x, _ = windings(surface, surface.low, surface.high, CELLS)
    if not len(x):
        raise SceneError(f"{name} has no volume to weigh: close its mesh, or set {name}.thickness")
    counted, told = float(np.prod(size / CELLS)) * len(x), volume_inside(surface)
    whole = told if abs(told - counted) < FAR_OFF * counted else counted
    center = x.mean(axis=0)
    second = whole / len(x) * _squares(np.ones(len(x)), x - center)
    return MassProperties(whole, center, np.trace(second) * np.eye(3) - second)
