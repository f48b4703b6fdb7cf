"""The section of an emitter: the part of a plane across the flow through which snow comes out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import cross
from neve.reproducible import norms, product
from neve.sampling.regions import Region, region
from neve.scene.schema.scene import Numerics
from neve.scene.schema.sources import Emitter

Array = NDArray[np.float64]

RASTER = 1024
"""Points along each edge of the section's box, from which its area is counted."""


@dataclass(frozen=True)
class Section:
    """Hold the points of a plane that lie in a region, and a rectangle around them.

    Attributes:
        space: the region
        middle: of the rectangle, in the world [m] (3,)
        normal: of the plane, along the flow [1] (3,)
        axes: of the rectangle's edges [1] (2, 3)
        half: half of these edges [m] (2,)
    """

    space: Region
    middle: Array
    normal: Array
    axes: Array
    half: Array

    def holds(self, x: Array) -> NDArray[np.bool_]:
        """Return which points x [m] (n, 3) of the plane are in the section, (n,)."""
        return self.space.holds(x)

    def grid(self, count: NDArray[np.int64]) -> Array:
        """Return the middles [m] (n, 3) of so many cells (2,) along the edges of the rectangle."""
        i, j = np.meshgrid(*(np.arange(n) for n in count), indexing="ij")
        share = np.stack([i.ravel() + 0.5, j.ravel() + 0.5], axis=1) / count - 0.5
        return np.asarray(self.middle + product(share * (2.0 * self.half), self.axes))

    @property
    def area(self) -> float:
        """Area [m2], counted in a raster of RASTER points along each edge: exact for a rectangle."""
        rows = np.array([1, RASTER])
        step = 2.0 * self.half[0] / RASTER
        held = 0
        for k in range(RASTER):
            line = self.grid(rows) + (k + 0.5 - 0.5 * RASTER) * step * self.axes[0]
            held += int(np.count_nonzero(self.holds(line)))
        return float(4.0 * self.half[0] * self.half[1] * held / RASTER**2)


def section_of(emitter: Emitter, numerics: Numerics, name: str) -> Section:
    """Return the section of `emitter` across its velocity, through the middle of the box around its shape.

    The edges follow those two of the shape's own axes that lie least along the velocity. `name`: used in
    messages. Errors: SceneError as `neve.sampling.regions.region`.
    """
    space = region(emitter, numerics, name)
    normal = np.array(emitter.velocity) / emitter.speed
    own = space.rotation.T
    along = product(own, normal)
    first = own[sorted(np.argsort(np.abs(along), kind="stable")[:2])[0]]
    a = first - product(normal[None], first[:, None])[0, 0] * normal
    a = a / norms(a)
    axes = np.stack([a, cross(normal, a)])
    half = 0.5 * product(np.abs(product(axes, own.T)), space.size)
    return Section(space, space.center + product(space.rotation, space.middle), normal, axes, half)
