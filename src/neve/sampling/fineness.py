"""How many particles a scene takes, and the grid with which it takes as many as one wants."""

from __future__ import annotations

from decimal import ROUND_FLOOR, Decimal

from neve.sampling.regions import region
from neve.scene.schema.scene import Scene

FINE = 2_000_000
"""Particles of a fine scene."""
ENOUGH = 1_000_000
"""Particles from which a scene is fine as it is."""


def particles_of(scene: Scene) -> float:
    """Return about how many particles the sources take: volume over the cube of the particles' distance.

    Errors: SceneError for a font or a mesh that cannot be used.
    """
    spacing = scene.numerics.spacing
    return sum(
        region(source, scene.numerics, f"sources.{i}").volume for i, source in enumerate(scene.sources)
    ) / (spacing**3)


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
