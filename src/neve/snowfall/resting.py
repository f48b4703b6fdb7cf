"""Snow that a run left, as a surface onto which more snow falls, and as particles of another run."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.triangles import Triangles
from neve.sampling import Samples
from neve.sampling.regions import Region
from neve.sampling.room import require_room_for_all
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Numerics, Snow, Source
from neve.snowfall.files import FORMAT, NEEDS, Arrays
from neve.surface.mesh import snow_surface

Array = NDArray[np.float64]

REACH = 0.62
"""Radius of the ball that a particle fills, in distances of particles: (3 / (4 pi))^(1/3)."""


@dataclass(frozen=True, eq=False)
class Resting:
    """Hold the particles of snow that lies still.

    Attributes:
        x: positions [m], (n, 3)
        m: masses [kg], (n,)
        V0: rest volumes before plastic change [m3], (n,)
        J_P: plastic volume change [1], (n,): the snow takes V0 J_P
        stiffness, strength: factors on Young's modulus and on the thresholds [1], (n,)
        growth: of strength by sintering [1], (n,)
        temperature: [deg C], (n,)
        liquid: share of the mass that is water [1], (n,)
        spacing: distance of particles [m]
    """

    x: Array
    m: Array
    V0: Array
    J_P: Array
    stiffness: Array
    strength: Array
    growth: Array
    temperature: Array
    liquid: Array
    spacing: float

    @property
    def volume(self) -> float:
        """Of the snow [m3]."""
        return float(np.sum(self.V0 * self.J_P))

    @cached_property
    def surface(self) -> Triangles:
        """The closed surface of the snow; particles without neighbours have none.

        Its undersides are half a distance of particles lower than those of its picture, which end some way
        above what bears them: so that no snow falls between.
        """
        middle = self.x.mean(axis=0)
        found = snow_surface(self.x - middle, self.spacing)
        vertices = found.vertices + middle
        vertices[:, 2] += 0.5 * self.spacing * np.minimum(found.normals[:, 2], 0.0)
        return Triangles(vertices, found.faces)

    def arrays(self) -> Arrays:
        """Return the arrays of a file that `resting_of` reads back."""
        own = {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}
        return {"lying_format": np.array(FORMAT), "kind": np.array("particles"), **own}


def resting_of(found: Arrays, key: str) -> Resting:
    """Return the particles of the arrays of a file. Errors: SceneError for a file that is damaged."""
    try:
        own: dict[str, Any] = {f.name: np.asarray(found[f.name], np.float64) for f in fields(Resting)}
        count = len(own["x"])
        for name, values in own.items():
            shape = {"x": (count, 3), "spacing": ()}.get(name, (count,))
            if values.shape != shape or not np.isfinite(values).all():
                raise ValueError(f"{name} is no such array")
        if not count or min(own[name].min() for name in ("m", "V0", "J_P", "stiffness", "spacing")) <= 0.0:
            raise ValueError("no snow")
    except (KeyError, ValueError, TypeError) as error:
        raise SceneError(f"{key} is damaged, or holds no particles of snow: {NEEDS}") from error
    return Resting(**{**own, "spacing": float(own["spacing"])})


def filled_resting(
    source: Source, snow: Snow, rest: Resting, numerics: Numerics, index: int
) -> tuple[Samples, Region]:
    """Return the particles of snow at rest for the scene's source number `index`, and the space they fill.

    They lie where they lay, with their mass, their plastic state and their strength; the stress in which they
    lay is gone, and comes back as they settle under their weight.

    Errors: SceneError for keys that this snow cannot have, or too many particles.
    """
    for key in ("structure", "variation", "profile"):
        if getattr(source, key) is not None and getattr(source, key) != "plain":
            raise SceneError(
                f"sources.{index}.{key} cannot be given with particles from a file: leave it out"
            )
    require_room_for_all(len(rest.x), numerics)
    samples = Samples(
        x=rest.x.copy(),
        v=np.broadcast_to(np.array(source.velocity), rest.x.shape).copy(),
        volume=rest.V0,
        stiffness=rest.stiffness,
        strength=rest.strength,
        density=rest.m / (snow.rho0 * rest.V0),
        temperature=rest.temperature,
        liquid=rest.liquid,
        growth=rest.growth,
        J_P=rest.J_P,
    )
    return samples, region_of_particles(rest)


def region_of_particles(rest: Resting) -> Region:
    """Return the space that the particles fill, in the axes of the world."""
    from scipy.spatial import cKDTree

    reach = REACH * rest.spacing
    low, high = rest.x.min(axis=0) - reach, rest.x.max(axis=0) + reach
    middle, tree = 0.5 * (low + high), cKDTree(rest.x)

    def inside(x: Array) -> NDArray[np.bool_]:
        return np.asarray(tree.query(x + middle, distance_upper_bound=reach)[0] <= reach)

    return Region(
        center=middle,
        rotation=np.eye(3),
        size=high - low,
        volume=rest.volume,
        inside=inside,
        depth=lambda x: np.zeros(len(x)),
        lowest=float(low[2]),
    )
