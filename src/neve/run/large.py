"""Say how much there is in a scene that takes more than a moment until its first frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene

MANY_PARTS = 1000
"""Parts of one list of a scene that take a while to make ready."""
MANY_PARTICLES = 5e6
"""Particles that do."""
LISTS = ("sources", "emitters", "sinks", "colliders", "bodies", "robots")


def in_words(scene: Scene) -> str:
    """Return how many parts and particles `scene` has; nothing if the first frame comes at once."""
    from neve.sampling.room import expected

    particles = sum(expected(source, scene.numerics) for source in scene.sources)
    counts = {name: len(getattr(scene, name)) for name in LISTS}
    if max(counts.values()) < MANY_PARTS and particles < MANY_PARTICLES:
        return ""
    parts = [f"{count:,} {name if count > 1 else ONE[name]}" for name, count in counts.items() if count]
    return f"{', '.join(parts)}, about {particles:.2g} particles"


ONE = {name: name.removesuffix("s") for name in LISTS} | {"bodies": "body"}
