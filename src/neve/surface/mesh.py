"""The surface of snow as a closed mesh of triangles, with normals and velocities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve._surface import Field
from neve.surface.grains import Grains
from neve.surface.kernels import kernels_of
from neve.surface.volume import amounts, points

Floats = NDArray[np.float32]

LEVEL = 0.5
"""Share of packed snow at which its surface lies."""
BLURS = 1
"""Times that the field of grains is blurred: with its B-spline a deviation of 0.87 cells."""
NEAREST = 4
"""Particles from which a vertex has its velocity."""


@dataclass(frozen=True)
class SurfaceMesh:
    """Hold a closed surface.

    vertices (n, 3) [m]; normals (n, 3): unit vectors, out of the snow; faces (m, 3): rows of vertices,
    counter-clockwise from outside; velocity (n, 3) [m/s], or None where it was not asked for
    """

    vertices: Floats
    normals: Floats
    faces: NDArray[np.int32]
    velocity: Floats | None = None

    @property
    def volume(self) -> float:
        """The volume inside [m3]: sum over triangles of a . (b x c) / 6 (divergence theorem)."""
        a, b, c = (self.vertices[self.faces[:, k]].astype(np.float64) for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def mesh_of(field: Field, level: float) -> SurfaceMesh:
    """Return the surface on which a field has the value `level`, by surface nets (Gibson 1998)."""
    return SurfaceMesh(*field.surface(level))


def snow_field(grains: Grains, weights: NDArray[Any] | None = None) -> Field:
    """Return the share of packed snow around each point, 1 inside, on cells as large as a grain.

    weights (n,): of each particle, about 1; its grains weigh as much. None: all 1.
    """
    each = amounts(1.0 if weights is None else np.repeat(weights, grains.count))
    return Field(grains.x, each, grains.size, BLURS)


def snow_surface(
    x: NDArray[Any],
    spacing: float,
    cell_size: float | None = None,
    v: NDArray[Any] | None = None,
    anisotropic: bool = False,
) -> SurfaceMesh:
    """Return the surface of snow as smooth as the particles are fine.

    The field is sum_p s^3 w_ip / cell_size^3, w the quadratic B-spline blurred by `BLURS`; the surface lies
    where it is `LEVEL`. A particle without any neighbour has none.

    x: positions (n, 3) [m]; spacing s: of particles at rest [m]; cell_size: of the grid [m], by default s,
    and s / 2 for anisotropic kernels (Yu and Turk 2013), which draw flat snow flat; v: velocities (n, 3)
    [m/s], for those of the vertices.
    """
    cell = cell_size or (0.5 * spacing if anisotropic else spacing)
    share = (spacing / cell) ** 3
    if anisotropic:
        field = kernels_of(x, spacing).field(share, spacing, cell, BLURS)
    else:
        field = Field(points(x), amounts(share), cell, BLURS)
    found = mesh_of(field, LEVEL)
    if v is None:
        return found
    return SurfaceMesh(found.vertices, found.normals, found.faces, velocity_at(found.vertices, x, v, spacing))


def velocity_at(places: NDArray[Any], x: NDArray[Any], v: NDArray[Any], spacing: float) -> Floats:
    """Return velocities (m, 3) [m/s] at places (m, 3): means over the nearest particles.

    u = sum_p v_p / (|x - x_p|^2 + (s/2)^2) over the `NEAREST` particles, normalised; s the spacing.
    """
    from scipy.spatial import cKDTree

    if not len(places) or not len(x):
        return np.zeros((len(places), 3), np.float32)
    far, near = cKDTree(np.asarray(x)).query(np.asarray(places), k=min(NEAREST, len(x)))
    far, near = far.reshape(len(places), -1), near.reshape(len(places), -1)
    weight = 1.0 / (far**2 + (0.5 * spacing) ** 2)
    weight /= weight.sum(axis=1, keepdims=True)
    return np.asarray(np.einsum("ij,ijk->ik", weight, np.asarray(v)[near]), np.float32)
