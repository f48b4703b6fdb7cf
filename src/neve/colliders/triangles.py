"""The surface of a solid as triangles, in its own frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.colliders.solid import Solid
from neve.geometry.heights import thinned, triangulated


def triangles(solid: Solid, far: float, most: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return corners (n, 3) [m] and triangles (m, 3), anticlockwise from outside.

    An endless plane is a square of 2 far [m]; of a terrain it is what its map shows, with `most` samples at
    most along each side.
    """
    if solid.mesh is not None:
        return np.asarray(solid.mesh.vertices, np.float64), solid.mesh.faces
    if solid.terrain is not None:
        return triangulated(*thinned(solid.terrain.heights, solid.terrain.size, most))
    vertices, faces = solid.form.unit_surface()
    return vertices * (np.full(3, far) if solid.endless else solid.half), faces
