"""Fill the sources of a scene with particles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import product
from neve.sampling.factors import factors, mixed_seed
from neve.sampling.points import jittered, poisson, regular
from neve.sampling.pressed.structure import chunks
from neve.sampling.regions import Region, region
from neve.sampling.room import require_room
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Collider, Numerics, Source

__all__ = ["Samples", "fill", "filled"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """Hold the particles of one source at the start.

    Attributes:
        x: positions [m], (n, 3)
        v: velocities [m/s], (n, 3)
        volume: share of the source's volume [m3], (n,); the sum is the volume of the shape, without what an
            outline of lumps leaves out of it
        stiffness: factor on Young's modulus [1], (n,)
        strength: factor on the thresholds of plastic flow [1], (n,)
        density: factor on density [1], (n,)
        temperature: [deg C], (n,); None: that of the scene's heat
        liquid: share of the mass that is water [1], (n,); None: 0
        growth: of strength by sintering [1], (n,); None: 1
        J_P: plastic volume change, of which the rest volume is without [1], (n,); None: 1
    """

    x: Array
    v: Array
    volume: Array
    stiffness: Array
    strength: Array
    density: Array
    temperature: Array | None = None
    liquid: Array | None = None
    growth: Array | None = None
    J_P: Array | None = None

    def only(self, chosen: NDArray[np.bool_]) -> Samples:
        """Return the particles that are `chosen` (n,)."""
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(self, **{name: a[chosen] for name, a in columns.items() if a is not None})


def fill(source: Source, numerics: Numerics, index: int, colliders: Sequence[Collider] = ()) -> Samples:
    """Return the particles in `source`, the scene's source number `index`; see `filled`."""
    return filled(source, numerics, index, colliders)[0]


def filled(
    source: Source, numerics: Numerics, index: int, colliders: Sequence[Collider] = ()
) -> tuple[Samples, Region]:
    """Place particles in `source`, the scene's source number `index`, and return the space that it fills.

    On average `particles_per_cell` particles lie in a volume dx^3. Each has the same share of the volume and
    moves with v = velocity + spin x (x - center). Its factors are described in `neve.sampling.factors`. With
    `structure = "chunks"` some are left out, see `neve.sampling.pressed.structure`: those that the outline
    does not hold, and so many of the others that the rest have the same mass each. Equal arguments give equal
    bits. `colliders`: of the scene, on whose terrain a mask may lie.

    Errors: SceneError if the source is too small or too large for dx, its font lacks a letter, its mesh has
    no inside, or its mask no snow.
    """
    name = f"sources.{index}"
    spacing = numerics.spacing
    space = region(source, numerics, name, colliders)
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
    share = np.full(len(local), space.volume / len(local))
    if source.structure != "chunks":
        made = factors(source, space, local, numerics.seed, index)
        return _moving(source, space, local, share, made), space
    built = chunks(space, local, mixed_seed(numerics.seed, index, source.structure_seed))
    kept = built.kept & (rng.random(len(local)) < built.crowd)
    if not kept.any():
        kept = built.kept
    made = factors(source, space, local, numerics.seed, index)
    made = {factor: values * getattr(built, factor) for factor, values in made.items()}
    weight = np.where(kept, 1.0 / built.crowd, 0.0)
    share = weight * (share[built.kept].sum() / weight.sum())
    return _moving(source, space, local, share, made).only(kept), space


def _moving(source: Source, space: Region, local: Array, share: Array, made: dict[str, Array]) -> Samples:
    """Return the particles at `local` [m] (n, 3) with their shares of the volume and their factors."""
    arm = product(local + space.middle, space.rotation.T)
    return Samples(
        x=space.center + arm,
        v=np.array(source.velocity) + np.cross(np.array(source.spin), arm),
        volume=share,
        **made,
    )
