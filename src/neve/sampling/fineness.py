"""How many particles a scene takes, and the grid with which it takes as many as one wants."""

from __future__ import annotations

from decimal import ROUND_FLOOR, Decimal

import numpy as np

from neve.sampling.emitters.stream import stream
from neve.sampling.regions import region
from neve.scene.schema.scene import Scene

FINE = 2_000_000
"""Particles of a fine scene."""
ENOUGH = 1_000_000
"""Particles from which a scene is fine as it is."""


def particles_of(scene: Scene) -> float:
    """Return about how many particles there are: those of the sources, and all that emitters add in the run.

    Those of a source are its volume over the cube of the particles' distance.

    Errors: SceneError for a font or a mesh that cannot be used.
    """
    spacing = scene.numerics.spacing
    return sum(
        region(source, scene.numerics, f"sources.{i}", scene.colliders).volume
        for i, source in enumerate(scene.sources)
    ) / (spacing**3) + emitted_by(scene, scene.run.duration)


def emitted_by(scene: Scene, end: float) -> float:
    """Return about how many particles emitters add until `end` [s]. Errors: SceneError, see `stream`."""
    return sum(stream(scene, i).expected(0.0, end) for i in range(len(scene.emitters)))


def placed_in(scene: Scene) -> float:
    """Return how many particles are placed before an outline or a solid takes some away.

    As `particles_of`, with the whole number of cells that a lattice has along each edge of a source's box.
    Errors: SceneError as there.
    """
    numerics, total = scene.numerics, emitted_by(scene, scene.run.duration)
    for i, source in enumerate(scene.sources):
        space = region(source, numerics, f"sources.{i}", scene.colliders)
        edges = space.size / numerics.spacing
        fitted = edges if numerics.sampling == "poisson" else np.maximum(np.rint(edges), 1.0)
        total += space.volume / float(np.prod(space.size)) * float(np.prod(fitted))
    return total


def finer(scene: Scene) -> Scene:
    """Return the scene with the grid spacing that makes about `FINE` particles of its snow.

    dx' = dx (N / FINE)^(1/3), with three digits, N the particles of `scene`; one that has `ENOUGH` is
    returned as it is. Nothing else changes. Errors: SceneError.
    """
    count = particles_of(scene)
    if count >= ENOUGH:
        return scene
    wanted = Decimal(scene.numerics.dx * (count / FINE) ** (1.0 / 3.0))
    dx = float(wanted.quantize(Decimal(1).scaleb(wanted.adjusted() - 2), rounding=ROUND_FLOOR))
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"dx": dx})})
