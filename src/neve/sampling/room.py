"""Whether there is room for the particles of a source: their number, and the memory that they take."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.scene.errors import SceneError
from neve.scene.schema.scene import Numerics
from neve.system.memory import lacking

MOST = 2**28
"""Points that may be placed in the box around a source."""
POINT_BYTES, PARTICLE_BYTES = 25, 240
"""Memory for each point of the box, and for each particle until the simulation has its own arrays [bytes]."""


def require_room(size: NDArray[np.float64], volume: float, numerics: Numerics, name: str) -> None:
    """Refuse a source that would take too many particles, or more memory than is free.

    size: edges of the box around it [m] (3,); volume: of its snow [m3]. Particles are chosen among points
    that fill the box, at least one along each edge.

    Errors: SceneError.
    """
    points = float(np.prod(np.maximum(size / numerics.spacing, 1.0)))
    share = min(volume / float(np.prod(size)), 1.0) if np.prod(size) > 0 else 1.0
    particles = points * share
    chosen = (
        "" if not particles <= MOST < points else f", chosen among {points:.2g} points of the box around it,"
    )
    stated = f"{name} would take {particles:.2g} particles{chosen} with numerics.dx = {numerics.dx:g}"
    if points > MOST:
        raise SceneError(f"{stated}, more than {MOST:.2g}; use a larger dx or a smaller source")
    if found := lacking(points * POINT_BYTES + particles * PARTICLE_BYTES):
        raise SceneError(f"{stated}, which {found}; use a larger dx or a smaller source")
