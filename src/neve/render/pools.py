"""Water that stands together: one smooth surface instead of drops."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve import _render
from neve._surface import Field
from neve.render.melt_water import WATER
from neve.surface.mesh import SurfaceMesh, mesh_of
from neve.surface.volume import amounts, points

CELL = 0.7
"""Cells of the grid of a pool, in particle spacings."""
BLURS = 2
"""Times that its water is blurred with (1, 2, 1) / 4: waves of a spacing are particles, not water."""
LEVEL = 0.22
"""Share of its room that water fills at the surface [1]: low enough that it reaches walls."""
AMONG = 0.3
"""Share from which on a particle belongs to a pool [1]; a lone one has 0.1."""
FEWEST = 100
"""Particles that make a pool."""
COLOR = (0.02, 0.075, 0.095)
"""Of deep water [linear sRGB], our choice."""


def pool_of(
    x: NDArray[Any], water: NDArray[Any], spacing: float
) -> tuple[NDArray[np.bool_], SurfaceMesh | None]:
    """Return which of the particles are water that stands together, (n,), and its surface.

    x (n, 3) [m]; water (n,): liquid shares; spacing of particles at rest [m].
    """
    inside = np.zeros(len(x), np.bool_)
    rows = np.flatnonzero((np.asarray(water) >= WATER) & np.isfinite(x).all(axis=1))
    if len(rows) < FEWEST:
        return inside, None
    places = points(np.asarray(x)[rows])
    field = Field(places, amounts(CELL**-3), CELL * spacing, BLURS)
    inside[rows] = np.asarray(field.sample(places)) >= AMONG
    surface = mesh_of(field, LEVEL) if inside.sum() >= FEWEST else None
    if surface is None or not len(surface.faces):  # drops that lie side by side
        return np.zeros(len(x), np.bool_), None
    return inside, surface


def as_solid(pool: SurfaceMesh) -> _render.Solid:
    """Return a pool for the quick picture, which sees no light through it: it mirrors like a dark metal."""
    vertices = np.ascontiguousarray(pool.vertices, np.float64)
    mesh = _render.Mesh(vertices, np.ascontiguousarray(pool.faces, np.int32))
    axes = [float(a) for a in np.eye(3).ravel()]
    return _render.Solid("mesh", (0.0, 0.0, 0.0), axes, (1.0, 1.0, 1.0), COLOR, "metal", mesh)
