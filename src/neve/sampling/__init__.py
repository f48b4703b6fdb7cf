"""Fill the sources of a scene with particles."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import product
from neve.sampling.factors import factors
from neve.sampling.points import jittered, poisson, regular
from neve.sampling.regions import region
from neve.sampling.room import require_room
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Numerics, Source

__all__ = ["Samples", "fill"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """Hold the particles of one source at the start.

    Attributes:
        x: positions [m], (n, 3)
        v: velocities [m/s], (n, 3)
        volume: share of the source's volume [m3], (n,); the sum is the volume of the shape
        stiffness: factor on Young's modulus [1], (n,)
        strength: factor on the thresholds of plastic flow [1], (n,)
        density: factor on density [1], (n,)
    """

    x: Array
    v: Array
    volume: Array
    stiffness: Array
    strength: Array
    density: Array

    def only(self, chosen: NDArray[np.bool_]) -> Samples:
        """Return the particles that are `chosen` (n,)."""
        return Samples(**{field.name: getattr(self, field.name)[chosen] for field in fields(self)})


def fill(source: Source, numerics: Numerics, index: int) -> Samples:
    """Place particles in `source`, the scene's source number `index`.

    On average `particles_per_cell` particles lie in a volume dx^3. Each has the same share of the volume and
    moves with v = velocity + spin x (x - center). Its factors are described in `neve.sampling.factors`.
    Equal arguments give equal bits.

    Errors: SceneError if the source is too small or too large for dx, its font lacks a letter, or its
    mesh has no inside.
    """
    name = f"sources.{index}"
    spacing = numerics.spacing
    space = region(source, numerics, name)
    require_room(space.size, space.volume, numerics, name)
    rng = np.random.default_rng([numerics.seed, index])
    if numerics.sampling == "poisson":
        local = poisson(space.size, spacing, rng, numerics.seed)
    elif numerics.sampling == "regular":
        local = regular(space.size, spacing)
    else:
        local = jittered(space.size, spacing, rng)
    local = local[space.inside(local)]
    if not len(local):
        raise SceneError(
            f"{name} is too small for a single particle with numerics.dx = {numerics.dx:g}; "
            "use a smaller dx or a larger source"
        )
    arm = product(local + space.middle, space.rotation.T)
    return Samples(
        x=space.center + arm,
        v=np.array(source.velocity) + np.cross(np.array(source.spin), arm),
        volume=np.full(len(local), space.volume / len(local)),
        **factors(source, space, local, numerics.seed, index),
    )
