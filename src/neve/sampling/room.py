"""Whether there is room for the particles of a source: their number, and the memory that they take."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.scene.errors import SceneError
from neve.scene.schema.scene import Numerics, Source
from neve.system.memory import lacking

MOST = 2**28
"""Points that may be placed in the box around a source."""
POINT_BYTES, PARTICLE_BYTES = 25, 240
"""Memory for each point of the box, and for each particle until the simulation has its own arrays [bytes]."""
CELL_BYTES = 200
"""Memory for each cell of an emitter's section while a layer of it comes out [bytes]."""
MOST_PARTICLES = 2**31 - 1
"""Particles of all sources together."""
SAMPLE_BYTES = 80
"""Memory for each particle while the sources are filled one after the other [bytes]."""
STATE_BYTES = {"float32": 200, "float64": 400}
"""Memory for each particle of a simulation [bytes], with the first four modes of its velocity."""
MODE_BYTES = {"float32": 12, "float64": 24}
"""Memory for each further mode of a particle [bytes]."""


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
    needed = points * POINT_BYTES + particles * PARTICLE_BYTES
    _require(stated, points, MOST, needed, "use a larger dx or a smaller source")


def require_room_in_section(cells: NDArray[np.float64], numerics: Numerics, name: str) -> None:
    """Refuse an emitter whose section has too many cells, or more than there is memory for.

    cells: along the two edges of the rectangle around the section (2,).

    Errors: SceneError.
    """
    points = float(np.prod(cells))
    stated = f"{name} has a section of {points:.2g} particles with numerics.dx = {numerics.dx:g}"
    _require(stated, points, MOST, points * CELL_BYTES, "use a larger dx or a smaller emitter")


def expected(source: Source, numerics: Numerics) -> float:
    """Return about how many particles `source` takes; 0 where only a file or a font tells."""
    return float(source.volume() / numerics.spacing**3)


def require_room_for_all(particles: float, numerics: Numerics, held: bool = False) -> None:
    """Refuse sources that would together take too many particles, or more memory than is free.

    held: whether they are placed, so that memory is needed for the simulation's own arrays alone.

    Errors: SceneError.
    """
    stated = f"all sources together would take {particles:.2g} particles with numerics.dx = {numerics.dx:g}"
    modes = numerics.polypic_modes if numerics.transfer == "polypic" else 0
    each = STATE_BYTES[numerics.precision] + max(modes - 4, 0) * MODE_BYTES[numerics.precision]
    needed = particles * (each + (0 if held else SAMPLE_BYTES))
    _require(stated, particles, MOST_PARTICLES, needed, "use a larger dx or less snow")


def _require(stated: str, count: float, most: float, needed: float, advice: str) -> None:
    """Refuse `stated` if `count` is above `most`, or `needed` bytes are not free. Errors: SceneError."""
    if count > most:
        raise SceneError(f"{stated}, more than {most:.2g}; {advice}")
    if found := lacking(needed):
        raise SceneError(f"{stated}, which {found}; {advice}")
