"""Throw a ball of snow."""

from __future__ import annotations

from neve.scene.errors import SceneError
from neve.scene.schema.scene import Source
from neve.viewer.protocol.commands import Throw

MOST_THROWN = 200_000
"""Particles of a ball that may be thrown."""


def ball_of(throw: Throw, spacing: float) -> Source | None:
    """Return the ball that a page throws, None if it names no direction. spacing: of particles [m].

    Errors: SceneError for a ball of too many particles.
    """
    norm = sum(a * a for a in throw.direction) ** 0.5
    if norm < 1e-9:
        return None
    many = 4.2 * (throw.radius / spacing) ** 3
    if many > MOST_THROWN:
        raise SceneError(f"a ball of {throw.radius:g} m has {many:.2g} particles: throw a smaller one")
    way = [a / norm for a in throw.direction]
    return Source.of(
        "sphere",
        center=tuple(o + 2 * throw.radius * w for o, w in zip(throw.origin, way, strict=True)),
        radius=throw.radius,
        velocity=tuple(throw.speed * w for w in way),
    )
