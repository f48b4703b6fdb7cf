"""The surfaces of solids as triangles, in their own frames."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.colliders.solid import Solid
from neve.colliders.triangles import triangles

Floats = NDArray[np.float32]
Faces = NDArray[np.int32]

FAR = 20.0
"""Half of the side of the square that stands for an endless plane [m]."""
MOST_HEIGHTS = 512
"""Samples of a height map along each side at most: a larger one is thinned."""


class SolidSurface(NamedTuple):
    """Hold the triangles of a solid in its own frame.

    name: of the solid, such as "bodies.1". word: the same of letters, digits and _ alone, in no other solid's
    name. vertices (n, 3), in the unit of the file. faces (m, 3): rows of
    vertices, anticlockwise from outside. color: red, green and blue, linear, or None
    """

    name: str
    word: str
    vertices: Floats
    faces: Faces
    color: tuple[float, float, float] | None


def surfaces(solids: tuple[Solid, ...], scale: float) -> list[tuple[int, SolidSurface]]:
    """Return the surface of each solid that can be seen, with its place in the list; scale: units in 1 m."""
    found: list[tuple[int, SolidSurface]] = []
    words: set[str] = set()
    for i, solid in enumerate(solids):
        word = "".join(c if c.isascii() and c.isalnum() else "_" for c in solid.name)
        while word in words:
            word += f"_{i}"
        words.add(word)
        if solid.visible:
            vertices, faces = triangles(solid, FAR, MOST_HEIGHTS)
            scaled = np.asarray(vertices * scale, np.float32)
            found.append((i, SolidSurface(solid.name, word, scaled, faces, solid.color)))
    return found
